// SPDX-License-Identifier: MIT
// The gate: a pixel clock that comes in bursts, one for each line, and rests in between (setting
// `gate_edges`). The first edge of a burst names the edge that is line zero, as command `go` names
// one (token.h). Main loop only.
//
//     clock      |_|_|_|_|_|_|_|_|_|_|_|_|_|_|_|______________________|_|_|_|_|_|_|_
//                ^ first edge      ^ line zero, gate_edges behind it  ^ first edge
//     line        ..... armed .....|-- pixels --|.. the next one: armed ..
//
// A line that is armed waits for the first edge of a burst, however long. A line that is queued
// behind another one is armed by the board as soon as that one is done, which may be some edges
// after the next burst has begun: the burst's line zero must still be ahead, or it is a fault.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_GATE

#if FEATURE_GATE

// The clock is gated.
bool gate_on(void);

// Line zero is far enough behind the first edge of a burst for a line to get its place in between.
bool gate_fits(void);

// This axis, whose line waits for the clock or follows it, can do without the clock: it waits for a
// burst, or its line has made all its steps.
bool gate_spares(uint8_t axis);

// A line of this axis is over. When the burst is over, too, it must have had the edge that ends the
// line: a fault else, since the burst was too short, or its first edge was missing.
void gate_line_done(uint8_t axis);

// No edge has come for longer than edges of a burst are apart. Again in each round.
void gate_rest(void);
// Edges are not seen: nobody knows whether the clock rests.
void gate_unsure(void);
// An edge came at edge_ticks, and is to be taken next; no line needs the clock. Returns true when
// the edge is the first one of a burst.
bool gate_begins(uint32_t edge_ticks);
// An edge came and cannot be placed. Returns true when it is the first one of a burst.
bool gate_begins_unplaced(void);
// The newest edge came too soon. While lines wait nobody can tell then where a short rest was.
bool gate_edge_is_early(void);
// The newest edge is the first one of a burst: name line zero.
void gate_name_zero(void);

// An axis whose line before is not accounted for yet has another one for the burst that has begun.
bool gate_overruns(void);
// The front line of an axis that has just finished one is to be armed.
bool gate_arms_next(uint8_t axis);

#else

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
