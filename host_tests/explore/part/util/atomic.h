// SPDX-License-Identifier: MIT
// <util/atomic.h> of the explorer.
#pragma once

#include <avr/io.h> // as avr-libc's does

#include "explore/part.h"

#define ATOMIC_FORCEON      part_force_on
#define ATOMIC_RESTORESTATE part_restore
#define ATOMIC_BLOCK(leave)                                                              \
    for (unsigned char interrupts_were_on                                                \
         __attribute__((cleanup(leave))) = part_enter(),                                 \
         once = 1;                                                                       \
         once != 0;                                                                      \
         once = 0)

static inline unsigned char part_enter(void)
{
    unsigned char on = part_interrupts_on();

    part_cli();
    return on;
}

static inline void part_restore(const unsigned char *on)
{
    if (*on != 0) {
        part_sei();
    }
}

static inline void part_force_on(const unsigned char *on)
{
    (void)on;
    part_sei();
}
