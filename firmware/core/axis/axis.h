// SPDX-License-Identifier: MIT
// One axis: its queue, its line, its state. decode.h makes ring entries of its lines, and its
// ledger makes positions of the entries that the step interrupt has consumed. This module knows no
// hardware: the application passes in samples of what the step interrupt did. The bus brings blocks
// to axis_queue_block(); app/motion arms, places and releases lines; app/round.c decodes, and
// notices the end of a line. Main loop only.
//
//     block --> check --> queue --> line --> walk --> feed --> step ring --> step interrupt
//                         (decode.h takes it from here)            |
//                                                  ledger <--------+ samples
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "account/ledger.h" // struct ledger
#include "axis/lifecycle.h"
#include "build_features.h"     // FEATURE_LINE_DIVIDER, SEVERAL_AXES
#include "line/line.h"          // struct line
#include "line/line_check.h"    // struct line_check
#include "line/segment_queue.h" // struct segment_queue
#include "steps/walk.h"         // struct walk
#include "stream/feed.h"        // struct feed

// What became of a block. Only BLOCK_TAKEN changes the queue.
enum block_result {
    // The block was queued.
    BLOCK_TAKEN,
    // The block has the number of the block taken last: acknowledged, not queued again.
    BLOCK_REPEATED,
    // The number is neither the next nor the last one.
    BLOCK_WRONG,
    // No room for the whole block, or the axis is stopping: the host repeats the block later.
    BLOCK_FULL,
    // An entry is not possible (line_error has the reason), or the axis is REFUSED or FAULT.
    BLOCK_REFUSED,
};

// What the decoder does next with the line in work.
//
//     OUTSIDE --> PIECE --> STEPS --> PIECE --> ... --> OUTSIDE
//                  ^ |       | ^
//                  | v       v |
//               DRY,     AWAITS_TRAIN       EDGE_INSIDE --> STEPS, EDGE_BEHIND --> PIECE
//        PIXEL_AWAITS_TRAIN,
//          PIXEL_SINGLES
enum decode_phase {
    // No line is being decoded.
    DECODE_OUTSIDE,
    // The next piece of the line is due.
    DECODE_PIECE,
    // The next piece is due, but the queue was empty when the decoder needed a segment.
    DECODE_DRY,
    // The next piece is due, a whole pixel as one pulse train, but the interrupt still needs both
    // of its trains.
    DECODE_PIXEL_AWAITS_TRAIN,
    // Inside a whole pixel whose steps are entries of their own: no pulse train can make them.
    DECODE_PIXEL_SINGLES,
    // Inside a piece with steps.
    DECODE_STEPS,
    // Inside a piece whose steps are a pulse train, but the interrupt still needs both of its
    // trains.
    DECODE_AWAITS_TRAIN,
    // The feed still has something to write. A pixel edge follows, then steps.
    DECODE_EDGE_INSIDE,
    // The feed still has something to write. A pixel edge follows, then the next piece.
    DECODE_EDGE_BEHIND,
};

// Other modules read the members and change them by the functions below. The decoder also writes
// `phase`, line, walk, piece and feed. Feed and ledger may also be used by the functions of their
// own headers.
struct axis {
    // The state, which lifecycle_report() alone changes.
    struct lifecycle life;
    // enum decode_phase.
    uint8_t phase;
    // The line that was armed waits for the pixel clock and follows it.
    bool clocked : 1;
    // A block was taken since reset, so that block next_block - 1 exists.
    bool any_block : 1;
    // The newest line with backlash had to begin without knowing how much of the play was taken up.
    bool play_unknown : 1;
#if SEVERAL_AXES
    // Steps of an even piece before it is handed over as a pulse train, 0..TRAIN_STAGGER_MAX
    // (app/axes/axes.c).
    uint8_t stagger : 4;
    // Entries of the ring that the interrupt has made and the ledger has not passed, because a
    // waypoint will pass them. The round writes it before it decodes.
    uint8_t made_entries;
#endif
#if FEATURE_LINE_ENDS
    // The line that was begun last says that another line follows.
    bool more : 1;
    // The line that was armed said so too: the axis ends at the same line as its company.
    bool joint : 1;
    // Lines begun since the armed line; wraps.
    uint8_t lines_begun;
#endif
    // Lines that are queued up to their end mark and not decoded to it yet; the line in work counts
    // once its end mark is queued.
    uint8_t whole_lines;
    // enum line_error of the last refusal, or LINE_none_followed; 0 none.
    uint8_t line_error;
    // enum line_error of the first warning about the line queued last; 0 none.
    uint8_t line_warning;
    // Number that the next block must have; wraps.
    uint16_t next_block;
    // Step interrupts that came too late, since reset; wraps. faults.c counts them.
    uint16_t underruns;
    // First pixel of the refused entry, 1-based; 0 where no entry was refused.
    uint32_t line_error_pixel;
    // Line zero: the STEP edge of tick 0, in ticks since the timers started; wraps. Valid from
    // axis_place() on.
    uint32_t zero_ticks;
    // Lines that are not decoded yet.
    struct segment_queue queue;
    // The line in work. `phase` says which of line, walk and piece are valid.
    struct line line;
    // The place in the line's piece.
    struct walk walk;
    // The piece of the line in work.
    struct piece piece;
    // The writer's end of the stream, and the stream.
    struct feed feed;
    // The reader's end of the stream: the account of time and position.
    struct ledger ledger;
    // Checks each entry as it is queued; the newest entry of the queue was checked last.
    struct line_check check;
};

// What an axis is made of. Everything here must last as long as the axis.
struct axis_parts {
    // The ring that the axis's step interrupt reads.
    struct step_ring *ring;
    // The STEP_TRAINS trains of the step interrupt, or NULL: the axis makes single periods only.
    struct pulse_train *trains;
    // Memory of the queue.
    uint8_t *queue_bytes;
    // Size of that memory, bytes: a power of two, 8..32768.
    uint16_t queue_size;
    // Steps of an even piece before it is handed over as a pulse train, 0..TRAIN_STAGGER_MAX; of
    // several axes only.
    uint8_t stagger;
    // Length of the periods that the timer holds at its start, ticks: see ledger_reset().
    uint16_t first_period_ticks;
};

// A new axis: EMPTY, at position 0. Before the axis's step interrupt is enabled, whose engine must
// begin at slot 0 of the ring.
void axis_init(struct axis *axis, const struct axis_parts *parts);

#if FEATURE_LINE_ENDS
// These axes, one after the other in memory, are the company of each other: all axes of the board.
// Nothing is held. The axes must last as long as the program.
void axis_company(struct axis *axes, uint8_t count);

// hold: after the line in work no axis begins another line, unless an axis of its company has begun
// that line already. The board holds its axes while its bus is silent, where setting silence_waits
// says so; false ends that.
void axis_hold(bool hold);

// True once after an axis has ended because of axis_hold(), with its next line queued.
bool axis_take_held(void);
#endif

// Entries that a host sends at once.
struct block {
    // Number that the host gave the block.
    uint16_t number;
    // Memory of the entries. axis_queue_block() may change the bytes.
    uint8_t *bytes;
    // Number of bytes, 1..255; where the entries are not packed, a multiple of 4.
    uint8_t size;
    // The entries are packed (segment_pack.h); else each is 4 bytes big-endian: count, repeat.
    bool packed;
};

#if FEATURE_LINE_DIVIDER
// The divider in front of a block's first segment, if the block may be queued and no segment of
// another line comes before the divider. The caller may then write this divider into the setting
// from which the limits follow. Else 0.
uint16_t axis_block_divider(const struct axis *axis, const struct block *block);
#endif

// Queue a block: all of its entries or none. limits: what the present settings allow. The check
// takes time with every entry. On boards of several axes there are interludes, in which the axis
// may end its line or fail; the result is BLOCK_FULL where the block must therefore come again. A
// refused block makes an axis that is neither armed nor running REFUSED.
enum block_result axis_queue_block(struct axis *axis,
                                   const struct line_limits *limits,
                                   const struct block *block);

// Begin to decode the front line ahead: LOADED becomes ARMED. period: exact length of a pixel; it
// must neither change nor end before the line does. Returns false and changes nothing when the axis
// is not LOADED, or when the front line's first entries are not all queued.
bool axis_arm(struct axis *axis, const struct pixel_period *period);

// True when the line that axis_arm() would arm waits for the pixel clock; false when no entry is
// queued. Only while a start mark is at the front of the queue: between lines.
bool axis_waits_for_edge(const struct axis *axis);
// True when the line that axis_arm() would arm is a seek. *opening is then true if the seek waits
// for the switch to open. Only where axis_waits_for_edge() may be asked.
bool axis_seeks(const struct axis *axis, bool *opening);

// Line zero of the armed line is known, and its release is near: ARMED becomes STARTING.
// zero_ticks: ticks since the timers started. An axis in another state stays as it is.
void axis_place(struct axis *axis, uint32_t zero_ticks);

// The step interrupt was given the line: STARTING becomes RUNNING. Returns false when a fault or a
// stop came in between; the state then stays.
bool axis_released(struct axis *axis);

// The last period of the line was loaded: RUNNING becomes DONE, and then LOADING or LOADED if more
// is queued. An axis in another state stays as it is. The account must have passed all entries.
void axis_line_finished(struct axis *axis);

// Stop decoding, from every state: STOPPING. The caller halts the step engine; axis_discard() must
// follow when the timer is idle.
void axis_stop(struct axis *axis);

// A fault was latched: an axis that is armed or running stops decoding and becomes FAULT. Any other
// axis keeps its state and its queue. The caller halts the step engine.
void axis_fail(struct axis *axis);

// Discard every queued line and what is decoded of them, after axis_stop() and once the timer is
// idle: STOPPING becomes EMPTY. ring_slot: where the settled step engine reads next. The account
// must have come to the engine's last sample; its position stays.
void axis_discard(struct axis *axis, uint8_t ring_slot);

// The decoder has reached the end mark: begin the next line if it follows without a gap, else end
// the decoding. For decode.c alone.
//
// Axes that were armed with lines of LINE_START_MORE begin their next line all or none: the first
// one that comes to its end mark goes on only if each of the others has that line in its queue.
//
//     axis 0   | line 1    | line 2    |            axis 1's line 3 was not queued when axis 0 came
//     axis 1   | line 1    | line 2    |            to its end mark: line_error none_followed
//     decoded          ^ both have line 2
void axis_line_decoded(struct axis *axis, const struct pixel_period *period);

// True when the decoder waits until the interrupt is done with one of its two trains.
static inline bool axis_awaits_train(const struct axis *axis)
{
    return axis->phase == DECODE_AWAITS_TRAIN ||
           (SEVERAL_AXES && axis->phase == DECODE_PIXEL_AWAITS_TRAIN);
}

// True in a line whose end is not queued yet: more of it must come.
static inline bool axis_streams(const struct axis *axis)
{
    return axis->phase != DECODE_OUTSIDE && axis->whole_lines == 0;
}

// At least this many of the ring's entries were made by the interrupt and are not accounted for:
// the count is of a moment ago, and the interrupt has gone on. With a single axis nobody counts: 0.
static inline uint8_t axis_made_entries(const struct axis *axis)
{
#if SEVERAL_AXES
    return axis->made_entries;
#else
    (void)axis;
    return 0;
#endif
}

// Steps of an even piece before it is handed over as a pulse train. A single axis begins no train
// at the same time as another one: 0.
static inline uint8_t axis_stagger(const struct axis *axis)
{
#if SEVERAL_AXES
    return axis->stagger;
#else
    (void)axis;
    return 0;
#endif
}

// Entries in the ring that the ledger has not accounted for, 0..STEP_RING_CAPACITY.
static inline uint8_t axis_ring_fill(const struct axis *axis)
{
    return stream_used(&axis->feed.stream);
}
