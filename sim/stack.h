// SPDX-License-Identifier: MIT
//
// Stack high-water mark: RAM from the end of the image's variables to RAMEND is painted before the
// run; what is still painted afterwards has never been stack. A power cut leaves noise in RAM; that
// noise is the paint from then on.
//
//   .data .bss .noinit | canary | still painted: free |  has been stack  |
//                      _end     bottom                                   top = RAMEND
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
    uint32_t free_least; // bytes, as measured before the last power cut
};

// Finds the end of the variables in the image's symbols. False if it has none (not an AVR program).
bool stack_find(struct stack_watch *watch,
                const struct symbols *symbols,
                const avr_t *avr);

// Paints the RAM. Call at the start of a run.
void stack_paint(struct stack_watch *watch, avr_t *avr);

// RAM is about to be filled with noise: keeps the measurement so far.
void stack_before_noise(struct stack_watch *watch, const avr_t *avr);

// RAM has been filled with noise, the new paint.
void stack_after_noise(struct stack_watch *watch, const avr_t *avr);

// Bytes that the stack has never used so far.
uint32_t stack_free_bytes(const struct stack_watch *watch, const avr_t *avr);

// Bytes that it has used at most so far.
uint32_t stack_used_bytes(const struct stack_watch *watch, const avr_t *avr);
