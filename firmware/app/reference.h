// SPDX-License-Identifier: MIT
// The pixel clock as this board knows it: the exact period that lines are decoded with, where clock
// edges came and where the line that is the reference had planned them. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/clock_watch.h" // struct clock_watch

// The period of the settings. A line that is over is the clock's reference no longer.
void reference_apply_settings(void);

const struct pixel_period *reference_period(void);
const struct clock_watch *reference_watch(void);

// The place of the newest edge is known, and the clock does not rest.
bool reference_present(void);

// An edge at this time, ticks since the timers started. True when it belongs to a line; *pixel is
// then its number (clock_watch_edge()).
bool reference_edge(uint32_t edge_ticks, uint32_t *pixel);

// The newest edge was seen, but its place is not known.
void reference_edge_dropped(void);

// A line with this zero is the reference from now on.
void reference_follow(uint32_t zero_ticks);

// The clock rests, or its edges are not looked at: what comes next belongs to no line.
void reference_rest(void);

// Patience begins anew.
void reference_await_edge(void);

// Patience is over: 1.5 pixel periods and up to 28 us since the last edge, or since
// reference_await_edge().
bool reference_overdue(void);
