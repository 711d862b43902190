// SPDX-License-Identifier: MIT
// One axis from queued runs to ring entries, and back from consumed entries to positions. Knows no
// hardware: the application hands in samples of what the step interrupt did. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/feed.h"
#include "motion/ledger.h"
#include "motion/line.h"
#include "motion/line_check.h"
#include "motion/run_queue.h"
#include "motion/step_engine.h" // enum step_engine_state
#include "motion/walk.h"

enum axis_state {
    AXIS_EMPTY = 0,   // nothing queued
    AXIS_LOADING = 1, // a line is on its way
    AXIS_LOADED = 2,  // a whole line, or as much as the memory holds, can be armed
    AXIS_ARMED = 3,   // decoded ahead; waits for line zero
    AXIS_RUNNING = 4,
    AXIS_DONE = 5,    // the last line ended where it should; nothing queued
    AXIS_REFUSED = 6, // a run was refused; discard to recover
    AXIS_FAULT = 7,
};

enum block_result {
    BLOCK_TAKEN,
    BLOCK_REPEATED, // the block before: acknowledged, not queued again
    BLOCK_WRONG,    // out of order
    BLOCK_FULL,     // no room for all of it; repeat later
    BLOCK_REFUSED,  // a run is not possible; line_error says why
};

struct axis {
    uint8_t state;   // enum axis_state
    bool in_line;    // the decoder is inside a line
    bool walking;    //   and inside a piece with steps
    bool dry;        //   but the queue was empty when it needed a run
    bool awaits_run; // a run is due, but the interrupt still needs both of them
    bool edge_due;   // a pixel edge follows what the feed still has to write
    bool direction_known;
    uint8_t
        stagger; // steps of an even piece before it is handed over as a run (machine.c)
    uint8_t whole_lines; // lines queued from start to end mark
    uint8_t line_error;  // enum line_error of the last refusal
    uint8_t line_warning;
    bool any_block; // a block was taken since reset: next_block - 1 exists
    uint16_t next_block;
    uint16_t lines_done;
    uint16_t underruns;
    uint32_t line_error_pixel;
    uint32_t zero_ticks; // line zero (STEP edge of tick 0), since the timers started
    struct run_queue queue;
    struct line_check check;
    struct line line;
    struct piece piece;
    struct walk walk;
    struct feed feed;
    struct ledger ledger;
};

void axis_init(struct axis *axis,
               struct step_ring *ring,
               struct run *slots,
               uint8_t slot_count,
               uint16_t first_period_ticks);

// A block of `count` entries, each 4 bytes big-endian (count, repeat): all taken or none.
enum block_result axis_queue_block(struct axis *axis,
                                   const struct line_limits *limits,
                                   uint16_t block,
                                   const uint8_t *entries,
                                   uint8_t count);

// Decode the front line ahead. False when there is none to arm. always_take_up: the backlash
// policy; else backlash is inserted only when the direction changes or is not known.
bool axis_arm(struct axis *axis, const struct pixel_period *period, bool always_take_up);

// Of the front line, before axis_arm(): it waits for the pixel clock; it is a seek, for the switch
// to open.
bool axis_waits_for_edge(const struct axis *axis);
bool axis_seeks(const struct axis *axis, bool *opening);

// The last step of its line was made: done, or loaded if more is queued.
void axis_line_finished(struct axis *axis);

// Back to loaded is not possible once runs were decoded: forget every queued line.
void axis_discard(struct axis *axis, uint8_t ring_slot);

// Decode up to `budget` steps or periods into the ring, as far as there is space. Returns what is
// left of the budget: slow steps take more of it.
uint8_t axis_decode(struct axis *axis,
                    const struct pixel_period *period,
                    bool always_take_up,
                    uint8_t budget);

// True when axis_decode() has nothing it could do now.
bool axis_decoded(const struct axis *axis);

// Time decoded ahead of the interrupt, ticks; inside a run up to a tick a step too much.
uint32_t axis_ahead_ticks(const struct axis *axis);

// Entries waiting in the ring for the interrupt.
static inline uint8_t axis_ring_fill(const struct axis *axis)
{
    return (uint8_t)(axis->feed.head - axis->ledger.retired);
}
