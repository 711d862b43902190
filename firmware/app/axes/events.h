// SPDX-License-Identifier: MIT
// The event log: the newest faults and resets, kept for a host that connects later, as input
// registers from REG_EVENT_BASE on. A board without the memory for the log has empty functions.
// Main loop only.
//
//     register   0x0300   0x0301                       0x0309
//               | count  | number, code, axis, ... 8   | number, code, axis, ... 8 | ...
//                          the oldest event kept
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h"            // CONFIG_EVENTS
#include "wire/register_map.h" // REG_EVENT_*

// Code of a reset, to which its cause is added: the bits of input register reset_cause. The code of
// a fault is below this.
#define EVENT_RESET 0x0100u

#if FEATURE_EVENTS

// Empty the log and begin to count at 0.
void events_start(void);

// Append an event; the oldest event is overwritten when the log is full. code: enum fault, or
// EVENT_RESET plus the cause. axis: the axis of the fault. argument: the argument of the fault
// (faults.def). pixel: number of the pixel in the axis's line, 1-based. The time in milliseconds
// since reset is added here.
void events_note(uint16_t code, uint8_t axis, uint16_t argument, uint32_t pixel);

// Input register at this address, from REG_EVENT_BASE on; 0 where no event is kept. Word 0 is the
// number of events since reset, which wraps; events follow, the oldest first.
uint16_t events_word(uint16_t address);

// Write the whole events among `count` (1..125) registers from `address` on to *to, big-endian; an
// event that is not kept is zeros. Returns the number of words written, which is 0 when `address`
// is not the first register of an event, or when count does not reach the end of one.
uint8_t events_words(uint16_t address, uint8_t count, uint8_t *to);

#else

// Without FEATURE_EVENTS nothing is kept, and the registers read as 0.
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

static inline uint8_t events_words(uint16_t address, uint8_t count, uint8_t *to)
{
    (void)address;
    (void)count;
    (void)to;
    return 0;
}

#endif
