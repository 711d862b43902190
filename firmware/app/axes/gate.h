// SPDX-License-Identifier: MIT
// The gate: a pixel clock that comes in bursts, one for each line, and rests in between (setting
// `gate_edges`). The first edge of a burst names the edge that is line zero, as command `go` names
// one (token.h). Main loop only.
//
//     clock      |_|_|_|_|_|_|_|_|_|_|_|_|_|_|_|______________________|_|_|_|_|_|_|_
//                ^ first edge      ^ line zero, gate_edges after it   ^ first edge
//     line        ..... armed .....|-- pixels --|.. the next one: armed ..
//
// A line that is armed waits for the first edge of a burst, however long. The board arms a line
// that is queued after another one as soon as the other one is done, which may be some edges after
// the next burst has begun: the burst's line zero must still be ahead, or the board latches a
// fault.
//
// The module decides what an edge or a silence of the clock means; clock_edges.c asks it for each
// edge and each time-out, round.c at the end of each line.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_GATE

#if FEATURE_GATE

// True when the settings say that the clock is gated: `gate_edges` is not 0.
bool gate_on(void);

// True when line zero is far enough after the first edge of a burst for a line to get its place in
// between, or when the clock is not gated.
bool gate_fits(void);

// True when this axis, whose line waits for the clock or follows it, can do without the clock: it
// waits for a burst, or its line has made all its steps. False once a burst has named line zero.
// May advance the axis's account.
bool gate_spares(uint8_t axis);

// A line of this axis is over. When its burst ends, the burst must have had the edge that ends the
// line. Else the burst was too short, or its first edge was missing, and gate_rest() or
// gate_begins() latches fault pixel_clock_missing.
void gate_line_done(uint8_t axis);

// No edge has come for longer than edges of a burst are apart: the burst is over, and its lines are
// judged. In each round while that is so.
void gate_rest(void);
// Edges are not seen: nobody knows whether the clock rests.
void gate_unsure(void);
// An edge came at edge_ticks, ticks since the timers started, and is to be taken next; no line
// needs the clock. Returns true when the edge is the first one of a burst: the burst before is then
// judged, and the clock's phase begins again.
bool gate_begins(uint32_t edge_ticks);
// An edge came and cannot be placed in time. Returns true, once for each rest, when the edge is the
// first one of a burst.
bool gate_begins_unplaced(void);
// True when the newest edge came too soon after the edge before. Nobody can tell then where a short
// rest was.
bool gate_edge_is_early(void);
// The newest edge is the first one of a burst: name line zero, `gate_edges` edges later.
void gate_name_zero(void);

// True when a burst has named line zero while an axis still runs whose next line waits for that
// burst.
bool gate_overruns(void);
// True when the front line of this axis, which has just finished a line, is to be armed for the
// next burst. The caller arms it.
bool gate_arms_next(uint8_t axis);

#else

// Without FEATURE_GATE the clock is never gated.
static inline bool gate_on(void)
{
    return false;
}

static inline bool gate_fits(void)
{
    return true;
}

static inline bool gate_spares(uint8_t axis)
{
    (void)axis;
    return false;
}

static inline void gate_line_done(uint8_t axis)
{
    (void)axis;
}

static inline void gate_rest(void)
{
}

static inline void gate_unsure(void)
{
}

static inline bool gate_begins(uint32_t edge_ticks)
{
    (void)edge_ticks;
    return false;
}

static inline bool gate_begins_unplaced(void)
{
    return false;
}

static inline bool gate_edge_is_early(void)
{
    return false;
}

static inline void gate_name_zero(void)
{
}

static inline bool gate_overruns(void)
{
    return false;
}

static inline bool gate_arms_next(uint8_t axis)
{
    (void)axis;
    return false;
}

#endif
