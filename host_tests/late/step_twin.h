// SPDX-License-Identifier: MIT
//
// The step interrupt of a board with several axes in C: firmware/avr/hal/step_isr.S with the ways
// of a late interval (step_catch_up.inc), path by path. What the interrupt decides depends on the
// ring, on the engine, on what it has noted of earlier intervals, and on what it reads from its
// timer, in this order; the twin asks its caller for each of these reads and tells each write. So
// the twin knows no cycles: catch_up_test.c runs it on the very values that the assembly has read.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "ring/step_engine.h"
#include "ring/step_ring.h"

// The timer of an axis, as the interrupt sees it.
enum twin_register {
    TWIN_TOP_LOW, // OCRnA
    TWIN_TOP_HIGH,
    TWIN_EDGE_LOW, // OCRnB
    TWIN_EDGE_HIGH,
    TWIN_COUNT_LOW, // TCNTn
    TWIN_COUNT_HIGH,
    TWIN_CONTROL, // TCCRnA
    TWIN_FLAGS,   // TIFRn
    TWIN_MASK,    // TIMSKn
    TWIN_BEFORE,  // written: FLAG_PIXEL_CLOCK_BEFORE is set
    TWIN_REGISTERS,
};

struct twin_timer {
    void *owner;
    uint8_t (*read)(void *owner, enum twin_register which);
    void (*write)(void *owner, enum twin_register which, uint8_t value);
};

// How an interrupt ends.
enum twin_end {
    TWIN_RETURNS,
    TWIN_COMMAND, // C executes the command at `tail`
    TWIN_LATE,    // the pin is taken from the timer: the axis stops with a fault
};

struct twin {
    struct step_engine engine;
    const struct step_ring *ring;
    uint8_t last, before_low, before_high; // step_isr_last and its like
    bool has_clock;    // the axis whose timer captures the pixel clock
    uint8_t low_ticks; // of a period, ahead of its STEP edge (OCRnB)
    const struct twin_timer *timer;

    // Of the running interrupt.
    int8_t left; // r3
    enum twin_end end;
    uint16_t visited; // bits of enum twin_path: which ways it went
};

enum twin_path {
    TWIN_EQUAL,
    TWIN_SET,
    TWIN_SET_FAST,
    TWIN_SET_HIGH,
    TWIN_ENTRY_AHEAD,
    TWIN_SET_ANY,
    TWIN_STRETCH,
    TWIN_STRETCH_ENTRY,
    TWIN_NOTHING_TO_DO,
    TWIN_MOVE_HIGH,
    TWIN_BEFORE_EDGE,
    TWIN_BETWEEN_TRAINS,
    TWIN_PATHS,
};

// One interrupt.
enum twin_end twin_interrupt(struct twin *twin);
