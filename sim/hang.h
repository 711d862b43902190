// SPDX-License-Identifier: MIT
//
// Faults of a program, injected on request: instructions in flash are patched and restored, or the
// main program or the whole part stands still. The board passes `main` and `all` on to the run loop
// (run_loop.h).
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#include "plain.h"

#define HANG_PATCHES 16 // of flash at a time

struct hang {
    bool main; // the main program stands still, interrupts are served
    bool all;  // nothing runs: a loop with interrupts off
    bool kept; // every reset but a power-on leaves the faults as they are
    unsigned patches;
    struct {
        uint32_t address; // bytes
        uint16_t before;  // the opcode that belongs there
    } patch[HANG_PATCHES];
};

// The handler of this interrupt returns at its vector. False if HANG_PATCHES are in flash.
bool hang_vector(struct hang *hang,
                 avr_t *avr,
                 struct plain_program *program,
                 uint8_t vector);

// The instruction at this flash address (bytes) jumps to itself. False if HANG_PATCHES are in flash
// or no instruction can be at the address.
bool hang_at(struct hang *hang,
             avr_t *avr,
             struct plain_program *program,
             uint32_t address);

// The part is reset, or the faults end on request: restores the image, unless the faults are kept.
// A power-on ends even those.
void hang_end(struct hang *hang,
              avr_t *avr,
              struct plain_program *program,
              bool power_on);
