// SPDX-License-Identifier: MIT
// The pixel clock as this board knows it: the exact period that lines are decoded with, when clock
// edges came, and when the reference line had planned them. app/motion/clock_edges.c brings the
// edges; whoever starts, locks or judges lines asks here. The module holds the board's clock_watch
// and configures the board's lock_grid. Main loop only.
//
//     planned edges     |0        |1        |2        |3      reference_follow(); 0: line zero
//     edges            |          |          |        |       reference_edge()
//     error (ticks)    -          0          +        0
//
// Times of edges are ticks since the timers started, and wrap.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "axis/axis.h"         // struct axis
#include "clock/clock_watch.h" // struct clock_watch

// Use the periods of the settings, which were checked. reference_measure_anew() must follow where
// the settings stay as they are.
void reference_apply_settings(void);

// Measure the clock from the beginning, for lines with these settings. No line is the reference
// afterwards.
void reference_measure_anew(void);

// The exact period of the clock's edges, by the settings. The object lasts as long as the program.
const struct pixel_period *reference_period(void);
// The exact period of a pixel: as many of the clock's edges as setting `divider` says.
const struct pixel_period *reference_pixel(void);
// The number of edges seen, the newest edge and its error.
const struct clock_watch *reference_watch(void);

// True when the time of the newest edge is known and the clock does not rest.
bool reference_present(void);

// What an edge of the clock is to the lines.
enum edge_kind {
    // No edge of the clock that lines are locked to: a glitch.
    EDGE_FALSE,
    // An edge of the clock.
    EDGE_COUNTED,
    // A pixel edge of the reference line, or of the locked lines' grid.
    EDGE_OF_PIXEL,
};

// An edge came at edge_ticks (ticks since the timers started). A false one changes nothing but the
// counters; reference_number() counts the others. *pixel is the number of an EDGE_OF_PIXEL. Edges
// come in the order of time, each of them once.
enum edge_kind reference_edge(uint32_t edge_ticks, uint16_t *pixel);

// The number of the newest clock edge; it wraps. With lines that are locked to the clock it counts
// edges that were bridged and leaves false ones out; else it counts what came, lost edges included.
uint16_t reference_number(void);

// Number of clock edges from the edge that gives a line its place to line zero. The number follows
// from the settings alone, so that it is the same whatever the board is doing.
uint8_t reference_place_edges(void);

// `edges` edges came and were lost: count them.
void reference_count_lost(uint8_t edges);

// True when the clock has run long enough for lines to be locked to it, or had run for so long
// before it came to rest.
bool reference_settled(void);

// An edge came whose time is not known. The clock is alive, but no distance to the next edge can be
// computed.
void reference_edge_dropped(void);

// The line with this zero (ticks since the timers started) becomes the reference: later edges are
// compared with its plan.
void reference_follow(uint32_t zero_ticks);

// The clock rests, or its edges are not captured: the next edge belongs to no line. A lock keeps
// the period that it has measured.
void reference_rest(void);

// Restart the clock's time-out, as an edge does.
void reference_await_edge(void);

// True when the time-out is over: 1.5 clock periods and up to 28 us since the last edge, or since
// reference_await_edge(); with lines that are locked to the clock one period more for each edge
// that was bridged since. Whether that is a fault is the caller's question.
bool reference_overdue(void);
