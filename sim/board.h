// SPDX-License-Identifier: MIT
//
// One simulated board: the part with our models of timers, comparator and UART in it, its pins
// wired to the signals of firmware/hal/boards/<name>.def, its axes' mechanics.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include <sim_avr.h>

#include "board_pins.h"
#include "comparator.h"
#include "edges.h"
#include "eeprom.h"
#include "extint.h"
#include "irq_stats.h"
#include "bus.h"
#include "noise.h"
#include "pixel_clock.h"
#include "plant.h"
#include "plant_log.h"
#include "serial_log.h"
#include "skips.h"
#include "stack.h"
#include "symbols.h"
#include "timer16.h"
#include "uart.h"
#include "watchdog.h"
#include "wire_log.h"

#define BOARD_TIMERS  4
#define BOARD_PORTS   12 // 'A' to 'L'
#define BOARD_PULSES  64 // pixel pulses handed over ahead of time; a power of two
#define BOARD_ERROR   256
#define BOARD_PLAN    256 // deeds to come
#define BOARD_PATCHES 16

// What a home or limit pin saw, driven from outside.
struct board_switch {
    bool level;
    uint64_t cycle; // of its last change, 0 if there was none
    uint64_t
        first_cycle; // of the first edge of the change that made it, before all bouncing
};

struct board_axis {
    bool step, dir, enable; // levels
    uint64_t steps_rising;
    uint64_t step_cycles[2]; // of the last rising edge and the one before it (0: none)
    int64_t steps_signed;    // DIR low counts up
    struct plant plant;
    struct contact contact[PLANT_SWITCHES];
    struct board_switch switches[PLANT_SWITCHES];
};

// Why a part was reset: the flags of MCUSR, by bit.
enum board_cause {
    BOARD_POWER_ON,
    BOARD_EXTERNAL,
    BOARD_BROWN_OUT,
    BOARD_WATCHDOG,
    BOARD_CAUSES,
};

// A reset or a change of the supply that is to come when the running instruction has ended. Of two
// the later in this list happens.
enum board_want {
    BOARD_WANT_NONE,
    BOARD_WANT_EXTERNAL, // in the order of enum board_cause
    BOARD_WANT_BROWN_OUT,
    BOARD_WANT_WATCHDOG,
    BOARD_WANT_OFF,
    BOARD_WANT_ON,
    BOARD_WANT_CYCLE, // off and on in the same cycle
};

// One thing to come: BOARD_WANT_NONE drives a pin.
struct board_deed {
    uint64_t cycle;
    enum board_want want;
    char port;
    uint8_t bit;
    bool level;
};

struct board_plan {
    struct board_deed deed[BOARD_PLAN]; // in order of cycles
    unsigned count;
};

// A program gone astray (board_hang.c).
struct board_hang {
    bool main; // the main program stands still, interrupts are served
    bool all;  // nothing runs any more: a loop with interrupts off
    bool kept; // through every reset but a power-on
    unsigned patches;
    struct {
        uint32_t address; // bytes
        uint16_t before;
    } patch[BOARD_PATCHES];
};

struct board {
    int index;
    const struct board_kind *kind;
    avr_t *avr;
    avr_io_t reset_hook; // hears of every reset of the part
    struct edges *edges;
    struct serial_log *serial_log; // NULL for none
    struct plant_log *plant_log;   // NULL for none
    FILE *switch_log;              // NULL for none
    struct wire_log *wire_log;     // NULL for none
    char error[BOARD_ERROR];       // not empty: the board has stopped for this reason

    struct timer16 timer[BOARD_TIMERS];
    int timers;
    struct {
        char port;
        uint8_t bit;
    } icp[BOARD_TIMERS]; // input capture pin of each timer
    struct timer16_hooks timer_hooks;
    struct comparator comparator;
    struct comparator_hooks comparator_hooks;
    struct uart uart;
    struct uart_hooks uart_hooks;
    struct irq_stats stats;
    struct skips skips; // of the image

    struct {
        uint8_t port, ddr;                 // as last written
        uint8_t driven_mask, driven_level; // from outside
    } pins[BOARD_PORTS];
    struct board_axis axis[BOARD_AXES];
    struct {
        bool level;
        uint64_t changes;
        uint64_t cycle; // of the last one, 0 if there was none
        uint64_t rise;  // and of the last rise
    } permit;
    uint8_t switch_on[BOARD_PORTS][8]; // by pin (board_find_switches)

    struct pixel_pulse pulse[BOARD_PULSES];
    unsigned pulse_first, pulse_last;
    bool pulse_high;
    uint8_t strap; // GPIOR2 after a reset

    uint64_t sleep_cycles;
    uint64_t quantum_end;

    // Rarely looked at: behind what every instruction needs.
    struct eeprom eeprom;
    struct eeprom_hooks eeprom_hooks;
    struct watchdog watchdog;
    struct watchdog_hooks watchdog_hooks;
    struct extint extint;
    struct extint_hooks extint_hooks;
    struct stack_watch stack;
    struct symbols symbols; // of the image

    bool powered;
    uint8_t mcusr; // at the next reset
    struct noise ram_noise;
    enum board_want want;
    struct board_plan plan;
    struct board_hang hang;
};

// Loads an image into a new board. The board must stay where it is in memory. On failure returns
// false with a one-line reason in board->error.
bool board_open(struct board *board,
                int index,
                const char *kind_name,
                const char *image_path,
                struct bus *bus,
                struct edges *edges);

// The mechanics of one axis; its switches drive their pins from now on.
void board_set_plant(struct board *board,
                     unsigned axis,
                     const struct plant_settings *settings);

// Other knobs at run time; the contacts are at once what the switches then are.
void board_change_plant(struct board *board,
                        unsigned axis,
                        const struct plant_settings *settings);

// Runs until the board has reached this cycle (it may pass it by the rest of an instruction), or
// has stopped. True while it goes on.
bool board_run(struct board *board, uint64_t cycle);

// The program has ended by itself: sleep with interrupts off.
bool board_is_done(const struct board *board);

// Drives an input pin from outside at this cycle.
void board_drive_pin(
    struct board *board, char port, unsigned bit, bool level, uint64_t cycle);

// The level that a home or limit pin reads (an enum plant_switch).
bool board_switch_level(struct board *board, unsigned axis, unsigned which);

// Does something to the board at a cycle to come (board_plan.c). False if too much is planned.
bool board_plan_add(struct board *board, const struct board_deed *deed);

// Where the noise of memories begins: after a power cut they hold another stretch of it each time.
void board_seed(struct board *board, uint64_t seed);

// The BOARD_... of a name, -1 if there is none.
int board_cause_by_name(const char *name);

// Resets the part between two instructions. The board must be powered.
void board_reset(struct board *board, enum board_cause cause);

// The supply fails between two instructions, or comes back. Off: all pins are inputs, the byte of
// EEPROM that is being written is anything; the program does not run.
void board_power_off(struct board *board);
void board_power_on(struct board *board);

// The main program stands still where it is when interrupts are next on, and interrupts are served.
void board_hang_main(struct board *board);

// The part loops with interrupts off.
void board_hang_interrupts(struct board *board);

// An axis' step interrupt returns at its vector. False if there are too many patches.
bool board_hang_axis(struct board *board, unsigned axis);

// The instruction at this flash address (bytes) jumps to itself. False if there are too many
// patches or no instruction can be there.
bool board_hang_at(struct board *board, uint32_t address);

// Everything is as the image says again. A power-on ends even a hang that is kept.
void board_end_hang(struct board *board, bool power_on);

// A pixel pulse to come. False if the board's queue is full.
bool board_add_pulse(struct board *board, const struct pixel_pulse *pulse);

void board_close(struct board *board);

// ---- between the files of the board ----

// Stops the board with this error.
void board_refuse(void *board, const char *text);

// The pins of this port that a model listens to may have changed level (board_inputs.c).
void board_follow_inputs(struct board *board, unsigned port, uint64_t cycle);

// The level of a pin as the program would read it (board_inputs.c).
bool board_pin_level(void *board, char port, unsigned bit);

// The comparator's output, or whether timer 1 captures it, may have changed (board_inputs.c).
void board_follow_comparator(void *board, uint64_t cycle);

// Finds the input capture pin of a timer (board_inputs.c).
void board_find_icp(struct board *board, int timer);

// Puts the board's reset behind those of simavr's modules (board_reset.c).
void board_append_reset_hook(struct board *board);

// Asks for a reset or a change of the supply from within an instruction or event (board_reset.c).
void board_want(struct board *board, enum board_want want);
void board_want_watchdog(void *board);

// Tells simavr when the next deed of the plan is due (board_plan.c).
void board_schedule_plan(struct board *board);

// The timer of an axis (board_outputs.c).
struct timer16 *board_axis_timer(struct board *board, unsigned axis);

// Tells simavr when the next pixel pulse is due (board_inputs.c).
void board_schedule_pulse(struct board *board);

// Finds the pins of the switches (board_switches.c).
void board_find_switches(struct board *board);

// A pin is driven at this cycle: the log, if it is a switch's (board_switches.c).
void board_log_switch(
    struct board *board, unsigned port, unsigned bit, bool level, uint64_t cycle);

// A step has moved a switch of this axis (board_switches.c).
void board_follow_plant(struct board *board, unsigned axis, uint64_t cycle);

// A row of the plant log, if there is one and the axis has a plant.
void board_log_plant(struct board *board, unsigned axis, uint64_t cycle);

// Tells simavr when a contact next does something (board_switches.c).
void board_schedule_switches(struct board *board);

// Follows the ports that carry outputs (board_outputs.c).
void board_watch_outputs(struct board *board);

// A reset has made all pins inputs. simavr does not say so, would keep the program's first write to
// itself if it repeats the last one before the reset, and reads every pin as low until it next
// changes (board_outputs.c).
void board_release_outputs(struct board *board);

// An output compare changed a pin's level or connection (board_outputs.c).
void board_compare_output(void *board,
                          struct timer16 *timer,
                          int channel,
                          uint64_t cycle);

// The driver of the serial line is on (board_outputs.c).
bool board_may_send(void *board);
