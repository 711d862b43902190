// SPDX-License-Identifier: MIT
//
// The outputs of a board: STEP, DIR, ENABLE, PERMIT and CLOCK_OUT with the exact cycles of their
// edges, and the driver enable of the serial bus. Every edge goes to the log of edges, every rising
// STEP edge to the mechanics. A pin that the program does not drive counts as low.
//
//   PORTx, DDRx written ------> DIR, ENABLE, PERMIT, driver enable
//   compare output OCnB ------> STEP, while the timer is connected to the pin (COMnB1:0)
//   PORTx, DDRx written ------> STEP, while it is not
//   compare output OC0B ------> CLOCK_OUT, while timer 0 is connected to the pin
//
// The functions that follow something are called by the board's wiring, within an instruction or an
// event of the part; everything else may be read at any time between two instructions.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "board_pins.h"
#include "edges.h"
#include "mechanics.h"
#include "own_time.h"
#include "ports.h"
#include "timer0.h"
#include "timers.h"
#include "uart.h"

// What the driver of an axis's motor has seen.
struct outputs_axis {
    bool step, dir, enable; // levels now
    uint64_t steps_rising;  // rising edges of STEP so far
    uint64_t step_cycles
        [2]; // the bench's, of the last rising edge and the one before it (0: none)
    int64_t steps_signed; // DIR low counts up
};

// What the device at the permit output has seen.
struct outputs_permit {
    bool level;       // now
    uint64_t changes; // edges so far
    uint64_t cycle;   // the bench's, of the last change, 0 if there was none
    uint64_t rise;    // and of the last rise
};

struct outputs_hooks {
    void *board;
    // CLOCK_OUT has this level from this cycle on.
    void (*clock_out)(void *board, bool level, uint64_t cycle);
};

struct outputs {
    const struct outputs_hooks *hooks;
    int board; // the board's number in the log of edges
    const struct own_time *time;
    const struct board_kind *kind;
    const struct ports *ports;
    struct timers *timers;
    const struct timer0 *timer0;
    struct mechanics *mechanics;
    struct uart *uart; // whose frame ends when the bus driver is switched off
    struct edges *edges;
    struct outputs_axis axis[BOARD_AXES];
    struct outputs_permit permit;
    bool clock_out; // level of CLOCK_OUT now
};

// The program has written PORTx or DDRx of this port (an index, 0 is port A): its pins change at
// this cycle.
void outputs_follow_port(struct outputs *outputs, unsigned port, uint64_t cycle);

// An output compare of this timer has a new level, or was connected or disconnected, at this cycle
// (channel 0 is A).
void outputs_follow_compare(struct outputs *outputs,
                            const struct timer16 *timer,
                            int channel,
                            uint64_t cycle);

// Compare output B of timer 0 has a new level, or was connected or disconnected, at this cycle.
void outputs_follow_timer0(struct outputs *outputs, uint64_t cycle);

// The driver of the serial bus is on. It always is if the program leaves its pin alone or the board
// has none: the program then uses the board's USB bridge.
bool outputs_may_send(const struct outputs *outputs);

// The timer that makes an axis's steps, NULL if the part does not have it.
struct timer16 *outputs_axis_timer(const struct outputs *outputs, unsigned axis);
