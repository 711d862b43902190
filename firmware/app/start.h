// SPDX-License-Identifier: MIT
// Placing line zero: every armed axis begins at the same instant, a whole number of pixel periods
// (one, when the period leaves the time) after a pixel clock edge.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// A pixel clock edge at this time: armed axes that wait for one get their line zero.
void start_on_edge(uint32_t edge_ticks);

// This armed axis does not wait for the pixel clock: as soon as it can.
void start_now(uint8_t axis);

// One that began on a clock edge.
bool start_clocked_axis_runs(void);

// With several axes: one waits for its release, a moment of a few milliseconds.
bool start_near(void);

// Release axes whose line zero is near.
void start_poll(void);
