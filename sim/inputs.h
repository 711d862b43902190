// SPDX-License-Identifier: MIT
//
// The inputs of a board: drives pins from outside, and passes every change of a pin on to the
// peripherals that listen to pins: the timers' input captures, the comparator and the external
// interrupts. The comparator may take the place of timer 1's capture pin.
//
//   inputs_drive() --> wire log --> ports --> switches' log
//                                     |
//   program writes DDRx, PORTx -------+--> input captures, comparator, external interrupts
//
// Within one call everything that listens has seen the change: a capture is due, a flag is set.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "comparator.h"
#include "extint.h"
#include "ports.h"
#include "switches.h"
#include "timers.h"
#include "wire_log.h"

// The parts of one board that inputs connects; all must outlive it.
struct inputs {
    struct ports *ports;
    struct timers *timers;
    struct comparator *comparator;
    struct extint *extint;
    struct switches *switches;
    struct wire_log *wire_log; // NULL for none
};

// Drives a pin from outside at this cycle, which may lie a few cycles back in the instruction that
// has just ended. Does nothing if the part has no such pin.
void inputs_drive(
    struct inputs *inputs, char port, unsigned bit, bool level, uint64_t cycle);

// Pins of this port (an index, 0 is port A) may have changed level at this cycle.
void inputs_follow_port(struct inputs *inputs, unsigned port, uint64_t cycle);

// The comparator's output, or whether timer 1 captures it, may have changed at this cycle.
void inputs_follow_comparator(struct inputs *inputs, uint64_t cycle);
