// SPDX-License-Identifier: MIT
// One axis: its queue, its lines, its state. decode.h turns its lines into ring entries, its ledger
// turns consumed entries into positions. Knows no hardware: the application hands in samples of what
// the step interrupt did. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/feed.h"
#include "motion/ledger.h"
#include "motion/lifecycle.h"
#include "motion/line.h"
#include "motion/line_check.h"
#include "motion/segment_queue.h"
#include "motion/walk.h"

enum block_result {
    BLOCK_TAKEN,
    BLOCK_REPEATED, // the block before: acknowledged, not queued again
    BLOCK_WRONG,    // out of order
    BLOCK_FULL,     // no room for all of it, or the axis is stopping; repeat later
    BLOCK_REFUSED,  // a run is not possible; line_error says why
};

// What the decoder does next with the line in work.
//
//     OUTSIDE --> PIECE --> STEPS --> PIECE --> ... --> OUTSIDE
//                  ^ |       | ^
//                  | v       v |
//                  DRY   AWAITS_RUN       EDGE_INSIDE --> STEPS, EDGE_BEHIND --> PIECE
enum decode_phase {
    DECODE_OUTSIDE,      // no line is in work
    DECODE_PIECE,        // the next piece is due
    DECODE_DRY,          //   but the queue was empty when it was needed
    DECODE_STEPS,        // inside a piece with steps
    DECODE_AWAITS_TRAIN, //   whose steps are a run, but the interrupt still needs both of them
    DECODE_EDGE_INSIDE, // a pixel edge follows what the feed still has to write; then steps
    DECODE_EDGE_BEHIND, // the same; then the next piece
};

struct axis {
    struct lifecycle life;
    uint8_t phase; // enum decode_phase
    bool clocked;  // the line that was armed waits for, and follows, the pixel clock
    bool direction_known;
    uint8_t stagger; // steps of an even piece before it is handed over as a run (axes.c)
    uint8_t whole_lines; // lines queued from start to end mark
    uint8_t line_error;  // enum line_error of the last refusal
    uint8_t line_warning;
    bool any_block; // a block was taken since reset: next_block - 1 exists
    uint16_t next_block;
    uint16_t lines_done;
    uint16_t underruns;
    uint32_t line_error_pixel;
    uint32_t zero_ticks; // line zero (STEP edge of tick 0), since the timers started
    struct segment_queue queue;
    struct line_check check;
    struct line line;
    struct piece piece;
    struct walk walk;
    struct feed feed;
    struct ledger ledger;
};

// What an axis is made of; all of it must last as long as the axis.
struct axis_parts {
    struct step_ring *ring;
    struct pulse_train
        *trains; // STEP_TRAINS runs of the step interrupt, or NULL: no runs
    struct segment *slots;
    uint8_t slot_count; // a power of two, 2..128
    uint8_t stagger;    // steps of an even piece before it is handed over as a run
    uint16_t first_period_ticks; // see ledger_reset()
};

// A new axis: EMPTY, at position 0.
void axis_init(struct axis *axis, const struct axis_parts *parts);

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

// The line has its place in time, and its release is near.
void axis_place(struct axis *axis, uint32_t zero_ticks);

// The step interrupt was given the line: RUNNING. False when a fault came between.
bool axis_released(struct axis *axis);

// The last period of its line was loaded: done, or loaded if more is queued.
void axis_line_finished(struct axis *axis);

// Decode no further, from every state: STOPPING. axis_discard() must follow when the timer is idle.
void axis_stop(struct axis *axis);

// A fault was latched: an axis that moves decodes no further.
void axis_fail(struct axis *axis);

// After axis_stop(), once the timer is idle: forget every queued line. ring_slot is where the step
// interrupt reads next.
void axis_discard(struct axis *axis, uint8_t ring_slot);

// A line follows the one that was decoded to its end without a gap, or the line is over.
void axis_line_decoded(struct axis *axis,
                       const struct pixel_period *period,
                       bool always_take_up);

// Entries waiting in the ring for the interrupt.
static inline uint8_t axis_ring_fill(const struct axis *axis)
{
    return (uint8_t)(axis->feed.head - axis->ledger.retired);
}
