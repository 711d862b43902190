// SPDX-License-Identifier: MIT
// A seek: an axis moves until its home switch is as sought. The switch's first edge is captured to
// the tick and counts when the filter confirms it. One axis at a time. Main loop only.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "config.h" // CONFIG_*, FEATURE_HOMING

enum trip_code {
    TRIP_NONE = 0,
    TRIP_CLOSED = 1,
    TRIP_OPENED = 2,
    TRIP_ALREADY = 3, // as sought from the start: no edge
};

struct seek {
    uint8_t axis; // that seeks now, NO_AXIS if none
    bool opening;
    bool captured;           // an edge, not confirmed yet
    uint8_t trip_axis;       // of the last seek
    uint8_t trip_code;       // enum trip_code
    uint16_t captured_units; // when the last edge was taken, low 16 bits
    uint32_t ticks;          // of the edge
    int32_t position_steps;  // at the edge
};

#if FEATURE_HOMING

void seek_start(void);

const struct seek *seek_now(void);

// The axis's front line is a seek and is about to be armed.
void seek_begin(uint8_t axis, bool opening);

void seek_poll(void);

// The input that captures the pixel clock captures the switch now.
bool seek_has_clock_input(void);

// This axis seeks, and an edge of its switch was captured and not taken.
bool seek_edge_waits(uint8_t axis);

// The captured edge becomes the axis's position 0. False without one.
bool seek_can_zero(uint8_t axis);
void seek_zero(uint8_t axis);

#else

static inline void seek_start(void)
{
}

static inline const struct seek *seek_now(void)
{
    return NULL;
}

static inline void seek_poll(void)
{
}

static inline bool seek_has_clock_input(void)
{
    return false;
}

static inline bool seek_edge_waits(uint8_t axis)
{
    (void)axis;
    return false;
}

#endif
