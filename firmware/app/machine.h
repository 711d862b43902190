// SPDX-License-Identifier: MIT
// The board as a whole: its axes, the pixel clock that starts them, and the policy for faults.
// Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "app/drivers.h"        // struct drivers
#include "app/events.h"         // struct events
#include "app/inputs.h"         // struct inputs
#include "app/seek.h"           // struct seek
#include "app/settings.h"       // struct settings
#include "base/names.h"         // enum fault
#include "config.h"             // CONFIG_AXES
#include "motion/axis.h"        // struct axis
#include "motion/clock_watch.h" // struct clock_watch

enum machine_command {
    COMMAND_NONE = 0,
    COMMAND_ARM = 1,
    COMMAND_DISARM = 2,
    COMMAND_STOP = 3,
    COMMAND_CLEAR_FAULT = 4,
    COMMAND_DISCARD = 5,
    COMMAND_ENABLE = 6,
    COMMAND_DISABLE = 7,
    COMMAND_ZERO = 8,
    COMMAND_PERMIT_ON = 9,
    COMMAND_PERMIT_OFF = 10,
    COMMAND_STORE = 11,
    COMMAND_DEFAULTS = 12,
    COMMAND_GO = 13,
    COMMAND_LAST = COMMAND_GO,
};

#define MACHINE_ORDER_WORDS 3u // mask, command, argument
#define MACHINE_MASK_MAX    15u
#define MACHINE_KEY 0x5AFEu // argument of commands that change what outlives a reset

struct fault_record {
    uint8_t code; // enum fault, the first since the last clear
    uint8_t axis;
    uint16_t argument;
    uint32_t mask; // bit n: fault n happened
    uint32_t pixel;
};

// machine.asking: 0, or commands are only asked about, a seek among them.
#define MACHINE_ASKS       1u
#define MACHINE_ASKED_SEEK 2u

struct machine {
    struct axis axes[CONFIG_AXES];
    struct run slots[CONFIG_AXES][CONFIG_QUEUE_ENTRIES];
    struct settings settings;
    uint16_t order[MACHINE_ORDER_WORDS]; // the last command and what came with it
    struct pixel_period period;
    struct line_limits limits;
    struct clock_watch watch;
    struct fault_record fault;
    struct inputs inputs[CONFIG_AXES];
    struct seek seek;
    struct drivers drivers;
#if CONFIG_EVENTS != 0
    struct events events;
#endif
    uint8_t starting; // bit n: axis n has a line zero and waits for its release
    uint8_t clocked;  // bit n: axis n needs the pixel clock
    uint8_t stopping; // bit n: axis n was told to stop; forget its lines when it rests
    bool permit;      // the permit output is on
    uint16_t token;   // that armed axes wait for, 0 none
    uint8_t turn;     // rounds, to look after one axis after the other
    uint8_t asking;   // commands are only asked about: MACHINE_ASKS, MACHINE_ASKED_SEEK
    bool time_lost;   // an underrun left the timers out of step with the ledgers
    uint32_t edge_seen_units; // when the last clock edge was handled
};

extern struct machine machine;

// One of the axes; with a single one its place is known when the image is built.
static inline struct axis *machine_axis(uint8_t axis)
{
    return &machine.axes[CONFIG_INDEX(axis)];
}

// Masks of axes: all of them, and one.
#define ALL_AXES ((uint8_t)((1u << CONFIG_AXES) - 1u))

static inline uint8_t axis_bit(uint8_t axis)
{
    return CONFIG_AXES == 1 ? 1u : (uint8_t)(1u << axis);
}

static inline struct inputs *machine_inputs(uint8_t axis)
{
    return &machine.inputs[CONFIG_INDEX(axis)];
}

// Interrupts off; time_check_start() must follow, and interrupts on before an idle period is over.
void machine_init(void);

// False when the command is not possible for every axis in the mask; then nothing is done. With
// machine.asking set nothing ever is, and the answer is the same.
bool machine_do(enum machine_command command, uint8_t mask);

// After a change of machine.settings.
void machine_apply_settings(void);

// Bring an axis's ledger up to what its interrupt has done by now. False when a captured edge must
// be taken first.
bool machine_follow(uint8_t axis);

// The same when that is worth the while: where the main loop can lag behind it does.
void machine_follow_due(uint8_t axis);

// The same at rest, whatever waits: before the account is cut short.
void machine_account(uint8_t axis);

// Bring an axis to rest and forget every line of it, from every state and however often: at once
// when its timer makes idle periods, else in a later round (machine.stopping).
void machine_discard(uint8_t i);

uint8_t machine_moving_axis(void); // the first armed or running one, CONFIG_AXES if none
bool machine_queued(void);         // or any line waiting, whole or in part
void machine_edge_dropped(
    void); // the clock's newest edge was seen, but its place is not known
uint32_t machine_clock_patience_units(void); // without an edge, until it is missing

// The place of its newest edge is known, and it does not rest.
static inline bool machine_clock_present(void)
{
    return machine.watch.known;
}

// The permit output: a laser's or a spindle's gate.
void machine_permit(bool on);

// Latch a fault, take the permit away and stop every axis.
void machine_fault(enum fault code, uint8_t axis, uint16_t argument);

// This axis's step interrupt came too late: latch it and stop every axis; time is to be restarted.
void machine_underrun(uint8_t axis);
