// SPDX-License-Identifier: MIT
// A seek: an axis moves until its home switch closes or opens. The switch's first edge is captured
// to the tick and counts when the filter confirms it. One axis at a time. Command arm begins a seek
// with its line; the round polls it; command zero makes the captured place position 0. Main loop
// only.
//
//     switch    ______/~\/~~~~~~~~~~~~~~~~~~~~~~~
//                     ^ captured  |-- filter --|
//     trip_code NONE                           CLOSED --> the line slows down
//     position  that of the captured edge
//
// A board with one axis captures the pixel clock and the switch with the same timer input, so that
// the clock is not observed during a seek.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "config.h" // CONFIG_*, FEATURE_HOMING

// How the seek ended, as the registers show it.
enum trip_code {
    // No edge is confirmed yet, or no seek was made, or the seek ended without one.
    TRIP_NONE = 0,
    // The switch closed: the position is that of the edge.
    TRIP_CLOSED = 1,
    // The switch opened: the position is that of the edge.
    TRIP_OPENED = 2,
    // The switch was in the sought state from the start: no edge.
    TRIP_ALREADY = 3,
};

// seek.c alone writes it.
struct seek {
    // The axis that seeks now, NO_AXIS if none.
    uint8_t axis;
    // The switch must open, else close.
    bool opening;
    // An edge was captured and was not found to be a disturbance.
    bool captured;
    // Axis of the last seek.
    uint8_t trip_axis;
    // enum trip_code.
    uint8_t trip_code;
    // When the last edge was taken, low 16 bits of clock_now_units().
    uint16_t captured_units;
    // Time of the first edge, ticks since the timers started; wraps.
    uint32_t ticks;
    // Position at that edge, steps; 0 after seek_zero().
    int32_t position_steps;
};

#if FEATURE_HOMING

// No seek, and no result of a seek. Capturing is off. Once at reset.
void seek_start(void);

// The running seek, or the result of the last one.
const struct seek *seek_now(void);

// The axis's front line is a seek and is about to be armed: capture its switch from now on. The
// result of the last seek is forgotten. opening: the seek ends when the switch opens, else when it
// closes. Only while no axis seeks.
void seek_begin(uint8_t axis, bool opening);

// Take the captured edge, confirm it, and end the seek when its line is over. A seek whose line
// ends without a confirmed edge latches fault home_not_found, or home_stuck where the switch should
// open; not after a stop. Once a round.
void seek_poll(void);

// True when the timer input that captures the pixel clock captures the switch now.
bool seek_has_clock_input(void);

// True when this axis seeks and has captured an edge of its home switch, until it is at rest or the
// edge was a disturbance. Not when the switch was as sought from the start.
bool seek_uses_switch(uint8_t axis);

// True when this axis seeks, and an edge of its switch was captured and not taken. The ledger must
// not pass the edge then, because the edge is placed by an older sample.
bool seek_edge_waits(uint8_t axis);

// True when the seek samples this axis in the capture's interrupt: the axis must not be parked.
bool seek_needs_interrupts(uint8_t axis);

// True when no axis seeks, the last seek was this axis's, and it ended with a confirmed edge.
bool seek_can_zero(uint8_t axis);
// Make the place of that edge the axis's position 0. Only when seek_can_zero(), for an axis at
// rest.
void seek_zero(uint8_t axis);

#else

// Without FEATURE_HOMING no axis seeks: the check of lines refuses seeks.
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

static inline bool seek_uses_switch(uint8_t axis)
{
    (void)axis;
    return false;
}

static inline bool seek_edge_waits(uint8_t axis)
{
    (void)axis;
    return false;
}

static inline bool seek_needs_interrupts(uint8_t axis)
{
    (void)axis;
    return false;
}

#endif
