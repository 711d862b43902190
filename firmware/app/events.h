// SPDX-License-Identifier: MIT
// The newest faults and resets, for a board that has the memory: input registers from
// REG_EVENT_BASE on. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h"            // CONFIG_EVENTS
#include "wire/register_map.h" // REG_EVENT_*

#define EVENT_RESET 0x0100u // code of a reset, plus its cause; else the fault's

#if FEATURE_EVENTS

void events_start(void);

void events_note(uint16_t code, uint8_t axis, uint16_t argument, uint32_t pixel);

uint16_t events_word(uint16_t address);

#else

static inline void events_start(void)
{
}

static inline void events_note(uint16_t code,
                               uint8_t axis,
                               uint16_t argument,
                               uint32_t pixel)
{
    (void)code;
    (void)axis;
    (void)argument;
    (void)pixel;
}

static inline uint16_t events_word(uint16_t address)
{
    (void)address;
    return 0;
}

#endif
