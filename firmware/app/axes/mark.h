// SPDX-License-Identifier: MIT
// The mark: every board on the bus notes the instant at which command `mark` ended. The command is
// broadcast and ends at the same instant everywhere. Each board also shows which edge of the pixel
// clock is its newest one, by its own count, and when that edge came, so that the host can tell how
// many edges the counts of two boards differ by. Main loop only.
//
//     clock      |         |         |         |
//     board 1   5300      5301      5302      5303      the mark lies at 5302.4
//     board 2   471       472       473       474       at 473.4: 4829 edges fewer
//     bus                      [mark]   ^ its end
//
// The registers show the struct; clock_edges.c and start.c report what happens to the clock and to
// lines, the command table the mark itself.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_TOKENS

// The functions below alone write it.
struct mark {
    // When the command ended, units of the coarse clock (hal/clock.h); wraps.
    uint32_t units;
    // When the timers started, units of the same clock.
    uint32_t started_units;
    // Number of the edge that is line zero of the line that began last.
    uint16_t zero_edge;
    // Marks since reset; wraps.
    uint8_t count;
    // Since the mark every edge came as it should. Not so: an edge came at an odd distance or was
    // lost, or the clock has stopped, which may have changed this board's count alone; or there was
    // no mark yet.
    bool steady;
};

#if FEATURE_TOKENS

// The newest mark, for the registers. Before the first one `count` is 0, and nothing is steady.
const struct mark *mark_now(void);

// A command ended just now that asks for a mark: the newest byte of the bus was its last one. What
// the clock did before no longer counts. The mark lies at the end of that byte, not at this call.
void mark_set(void);

// The timers started just now. Once for each start of time.
void mark_started(void);

// The clock was disturbed: an edge came at an odd distance, could not be placed or was lost, or the
// clock has come to rest. Nobody can tell any more whether this board has counted as the others
// have. With lines that are locked to the clock, only what the filter cannot make good disturbs: a
// clock of another frequency, and a false edge among the first ones after a rest.
void mark_disturb(void);

// Lines begin on the clock edge of this number (reference_number()): what register zero_edge shows
// until other lines begin.
void mark_zero(uint16_t edge);

#else

// Without FEATURE_TOKENS there are no registers that show a mark.
static inline const struct mark *mark_now(void)
{
    return 0;
}

static inline void mark_started(void)
{
}

static inline void mark_disturb(void)
{
}

static inline void mark_zero(uint16_t edge)
{
    (void)edge;
}

#endif
