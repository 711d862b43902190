// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.
//
// Stack high-water mark: RAM from the end of the image's variables to RAMEND is painted before the
// run; what is still painted afterwards has never been stack. A power cut leaves noise there, which
// is the paint from then on.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#include "symbols.h"

#define STACK_BYTES_MOST 16384U

struct stack_watch {
    uint16_t bottom; // first address after .data, .bss, .noinit and the firmware's canary
    uint16_t top;    // RAMEND
    uint8_t paint[STACK_BYTES_MOST];
    uint32_t free_least; // before the last power cut
};

// Finds the end of the variables in the image's symbols. False if it has none (not an AVR program).
bool stack_find(struct stack_watch *watch,
                const struct symbols *symbols,
                const avr_t *avr);

// Paints, at the start of a run.
void stack_paint(struct stack_watch *watch, avr_t *avr);

// RAM is about to be filled with noise.
void stack_before_noise(struct stack_watch *watch, const avr_t *avr);

// RAM now holds the new paint.
void stack_after_noise(struct stack_watch *watch, const avr_t *avr);

// Bytes never used by the stack so far. The used ones are top + 1 - bottom less these.
uint32_t stack_free_bytes(const struct stack_watch *watch, const avr_t *avr);
uint32_t stack_used_bytes(const struct stack_watch *watch, const avr_t *avr);
