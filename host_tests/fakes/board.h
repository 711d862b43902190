// SPDX-License-Identifier: MIT
// A board without hardware behind the hal's contracts: step timers, pixel clock, coarse
// clock, serial line. Time passes only by fake_pass(); then the step interrupts and
// captures happen that are due.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h"   // CONFIG_AXES
#include "hal/uart.h" // uart_divisor

struct fake_axis {
    int32_t steps;             // signed STEP edges so far
    uint32_t last_step_ticks;  // the newest of them,
    uint32_t first_step_ticks; //   and the first since this was last set to 0
    bool enabled;
};

extern struct fake_axis fake_axes[CONFIG_AXES];

// Power on: everything at rest, no pixel clock; step_timer_start() starts the timers.
void fake_power_on(void);

// Timer ticks since power on.
uint32_t fake_now_ticks(void);
void fake_pass(uint32_t ticks);

// Pixel clock edges at the pin, from first_ticks on in exact steps of 16 MHz * den / num;
// num 0 stops it.
void fake_pixel_clock(uint32_t first_ticks, uint32_t num, uint32_t den);
uint32_t fake_next_edge_ticks(void);

// Another edge came so close behind the newest one that it was not captured.
void fake_crowded_edge(void);

// Level of a switch's pin from now on; all are high at power on. `which` as in hal/switches.h.
void fake_switch(uint8_t axis, uint8_t which, bool high);

// The emergency stop pin from now on; high at power on. An edge to what trips halts every axis.
void fake_estop(bool high);

extern bool fake_permit;           // the permit output
extern uint16_t fake_clock_out_hz; // of the clock that the board makes
extern uint8_t fake_reset_cause;   // from the next start on
extern bool fake_stack_intact;
extern uint16_t fake_watchdog_feeds;

// The step interrupt of this axis came too late: its pin is taken from the timer.
void fake_underrun(uint8_t axis);

// The timer of this axis, at rest, holds a pulsing period.
void fake_stray_steps(uint8_t axis);

// A period of this axis passed without its interrupt: the newest one is repeated.
void fake_missed_period(uint8_t axis);

// So many ticks pass in the middle of the next release of a line, once.
void fake_slow_publish(uint32_t ticks);

// From now on so many ticks pass with each section of a round that the main loop enters: before and
// behind the advance of an account, and before and behind the decoding for an axis.
void fake_slow_sections(uint32_t ticks);

// Bytes to the board, all of them now; the number of those that it has begun to send since the last
// call. They stay until the next are received.
void fake_receive(const uint8_t *bytes, uint16_t length);
uint16_t fake_sent(const uint8_t **bytes);

// The receiver has lost so many bytes.
void fake_overrun(uint8_t bytes);

// What uart_set() was told last, and how often it was another than before.
struct fake_line {
    uart_divisor divisor;
    uint8_t parity;
    uint16_t silence_counts;
    uint8_t changes;
};

extern struct fake_line fake_line;

// This axis's step interrupt is never served again.
void fake_hang_axis(uint8_t axis);
