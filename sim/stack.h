// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.
//
// Stack high-water mark: RAM from the end of the image's variables to RAMEND is painted before the
// run; what is still painted afterwards has never been stack.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

struct stack_watch {
    uint16_t bottom; // first address after .data, .bss and .noinit
    uint16_t top;    // RAMEND
};

// Finds the end of the variables in the image's symbols. False if it has none (not an AVR program).
bool stack_find(struct stack_watch *watch, const char *elf_path, const avr_t *avr);

void stack_paint(const struct stack_watch *watch, avr_t *avr);

// Bytes never used by the stack so far. The used ones are top + 1 - bottom less these.
uint32_t stack_free_bytes(const struct stack_watch *watch, const avr_t *avr);
uint32_t stack_used_bytes(const struct stack_watch *watch, const avr_t *avr);
