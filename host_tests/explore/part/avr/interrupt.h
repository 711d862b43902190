// SPDX-License-Identifier: MIT
// <avr/interrupt.h> of the explorer. A naked handler is a few instructions around a body in C: the
// instructions are modelled in interrupts.c, the body is made known to it as explored_<name>.
#pragma once

#include "explore/part.h"

#define INT0_vect         estop_body
#define TIMER1_CAPT_vect  pixel_clock_body

#define ISR(vector, ...)              ISR_CHOICE(vector, ##__VA_ARGS__, ISR_PLAIN)
#define ISR_CHOICE(vector, form, ...) form(vector)
#define ISR_PLAIN(vector)             ISR_NAMED(vector)
#define ISR_NAMED(name)                                                                  \
    void explored_##name(void);                                                          \
    void explored_##name(void)
#define ISR_NAKED(vector) ISR_BODY(vector)
#define ISR_BODY(body)                                                                   \
    ISR_NAMED(body)                                                                      \
    {                                                                                    \
        body();                                                                          \
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
