// SPDX-License-Identifier: MIT
// <avr/interrupt.h> of the explorer. A naked handler is a few instructions around a body in C: the
// instructions are modelled in part.c, the body is made known to it as explored_<name>.
#pragma once

#include "explore/part.h"

// NOLINTBEGIN(readability-identifier-naming): avr-libc's names, and those made of them
#define INT0_vect estop_look
#define INT2_vect estop_look

#define ISR(...)                      ISR_CHOICE(__VA_ARGS__, ISR_PLAIN, 0)
#define ISR_CHOICE(vector, form, ...) form(vector)
#define ISR_PLAIN(vector)             ISR_NAMED(vector)
#define ISR_NAMED(name)                                                                  \
    void explored_##name(void);                                                          \
    void explored_##name(void)
#define ISR_NAKED(vector) ISR_BODY(vector)
// What the body returns to the instructions around it.
#define ISR_VALUE_estop_look(call) (call)
// NOLINTEND(readability-identifier-naming)
#define ISR_BODY(body)                                                                   \
    int explored_##body(void)                                                            \
    {                                                                                    \
        return ISR_VALUE_##body(body());                                                 \
    }                                                                                    \
    static inline __attribute__((unused)) void body##_entry(void)

static inline void cli(void)
{
    part_cli();
}

static inline void sei(void)
{
    part_sei();
}
