// SPDX-License-Identifier: MIT
// Edges of the pixel clock. Every captured edge goes one way, with one axis and with several. An
// edge that is lost, mistimed or missing is a fault of the axes that need the clock. Main loop
// only.
//
//     captured --> placed --> noted --------> judged ---------> starts lines --> its fault is
//                  ledger.h   reference.h,    by its distance,  start.h          latched
//                             records of      its lock or       (unless it has   faults.h
//                             the axes        its burst         a fault)
#pragma once

#include <stdbool.h>

#include "axis/axis.h" // struct axis

// Take the captured edges that wait. Once a round, before any other function follows the axes, and
// with several axes between two decodings.
void clock_edges_poll(void);

// Latch a fault when an edge is overdue. Once a round.
void clock_edges_miss(void);

// An axis is about to be armed for the clock: its time-out begins now, unless edges are already
// arriving. For lines that are locked to the clock: the first of them fixes the length of pixels
// that are decoded before line zero.
void clock_edges_await(void);

// The axis's front line may be armed as far as the clock is concerned: a line that is to be locked
// needs a clock that has run for some time.
bool clock_edges_allow(const struct axis *axis);
