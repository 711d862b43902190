// SPDX-License-Identifier: MIT
//
// The pixel clock's pulses on their way into one board: queued ahead of time, then driven onto the
// board's pin (and onto the copy of it, where the board has one), each edge in its exact cycle.
//
//   pulse[]   | rise, fall | rise, fall | rise, fall |      added by the bench, some way ahead
//                   |
//   pin       ______/----\_________                         driven by an event of the part
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#include "board_pins.h"
#include "inputs.h"
#include "pixel_clock.h"

#define PIXEL_INPUT_PULSES 64 // queued at most; a power of two

struct pixel_input {
    avr_t *avr;
    struct inputs *inputs;
    const struct board_pin *pin;
    const struct board_pin *copy; // a second pin with the same signal, NULL for none
    struct pixel_pulse pulse[PIXEL_INPUT_PULSES];
    unsigned first, last; // of the queued pulses; the difference is their number
    bool high;            // between the edges of the first one
};

// Finds the pins. Call once the part exists.
void pixel_input_attach(struct pixel_input *pixel_input,
                        avr_t *avr,
                        const struct board_kind *kind,
                        struct inputs *inputs);

// Queues a pulse, which must come after those already queued. False if the queue is full.
bool pixel_input_add(struct pixel_input *pixel_input, const struct pixel_pulse *pulse);

// Drives the pins at this cycle, without a queue: where a wire brings the clock.
void pixel_input_drive(const struct pixel_input *pixel_input, bool level, uint64_t cycle);

// Schedules the next edge. Call after a reset, which empties libsimavr's list of events.
void pixel_input_schedule(struct pixel_input *pixel_input);
