// SPDX-License-Identifier: MIT
// Edges of the pixel clock. Each edge gets its time, is compared with the plan of the running line,
// and starts armed axes. An edge that is lost, mistimed or missing is a fault of the axes that need
// the clock. Main loop only.
#pragma once

// Take a captured edge. Once a round, before any other function follows the axes.
void clock_edges_poll(void);

// Latch a fault when an edge is overdue. Once a round.
void clock_edges_miss(void);

// An axis is about to be armed for the clock: its time-out begins now, unless edges are already
// arriving.
void clock_edges_await(void);
