// SPDX-License-Identifier: MIT
// A seek: an axis moves until its home switch is as sought. The switch's first edge is captured to
// the tick and counts when the filter confirms it. One axis at a time. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

enum trip_code {
    TRIP_NONE = 0,
    TRIP_CLOSED = 1,
    TRIP_OPENED = 2,
    TRIP_ALREADY = 3, // as sought from the start: no edge
};

#define SEEK_NOBODY 0xFFu

struct seek {
    uint8_t axis; // that seeks now, SEEK_NOBODY if none
    bool opening;
    bool captured;           // an edge, not confirmed yet
    uint8_t trip_axis;       // of the last seek
    uint8_t trip_code;       // enum trip_code
    uint16_t captured_units; // when the last edge was taken, low 16 bits
    uint32_t ticks;          // of the edge
    int32_t position_steps;  // at the edge
};

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
