// SPDX-License-Identifier: MIT
// Edges of the pixel clock: each gets its place in time, tells how far the running line is from its
// plan, and starts what is armed. One that is lost, misplaced or missing is a fault of what needs
// the clock. Main loop only.
#pragma once

// Take an edge that was captured. Once a round, before anything else follows the axes.
void clock_edges_poll(void);

// Is an edge missing? Once a round.
void clock_edges_miss(void);

// An axis is about to be armed for the clock: patience begins now, unless edges are being seen.
void clock_edges_await(void);
