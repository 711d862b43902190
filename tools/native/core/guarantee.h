// SPDX-License-Identifier: MIT
// Whether a board can follow lines that run together: its main loop is replayed with the costs that
// were measured on its image, round by round, and every part of a line is asked for the time that
// is left when it has been decoded.
//
//     written  |====== ring: decoded, not made ======|
//     time     now                                   end of it, less two intervals: the deadline
//              |-- rounds, accounts, decoding --|     of the next part, less the longest request
//
// A part is what the decoder writes at once: a short pixel, a pulse train, up to 60 steps of a
// curve. Bounds that keep the decoder from running ahead are the ring's entries, two pulse trains,
// the marks of pixel edges, and of a locked line the edges of the clock that it has seen.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "line/segment.h" // struct segment

#define GUARANTEE_AXES 4u

// Cycles of the processor, interrupts excluded, unless said otherwise. The names are those of the
// table of costs.
struct guarantee_costs {
    double call; // of the decoder
    // Pixels of few even steps, more of one with another count than the one before it, and of one
    // behind a pixel of another kind.
    double even_px, even_step, even_changed, even_begun;
    double train_px, train_step;   // pixels that are a pulse train
    double single_px, single_step; // those that no pulse train can make
    // Short pixels under acceleration, more of one that does not go on as the one before it.
    double curved_px, curved_start, curved_step;
    double piece_px, piece_step, curve_px; // all others, even and curved
    double piece_more;                     // more of an even one with several steps
    double shifted_px;                     // and of one before backlash is taken up
    double turned_px;                      // and of one in the other direction
    double
        crawl_px; // and of one under acceleration that is slow at one end, and fast at the other
    // Steps of a curve, by how they are found; ticks by which an interval moves, of narrow curves
    // and of wide ones, or is guessed wrong; a batch of few steps.
    double flat_step, wide_step, steep_step, slow_step;
    double moved_tick, wide_moved_tick, missed_tick, short_batch;
    double zero_px, pump; // a part of a long wait
    double locked_px;     // more of each locked pixel
    double early;         // to ask for one that must wait for the clock, once a call
    // The account of what was made: a look, a pixel, an entry of a short pixel and of a long one,
    // a pixel of a curve, of another piece, more of any while there are pulse trains.
    double account, account_px, account_entry, account_long_entry;
    double account_curve_px, account_piece_px, account_train_px;
    // An edge of the clock, a pass of the main loop with nothing to do; of locked lines.
    double edge, round, edge_locked, round_locked;
    double edge_few; // more of an edge of others, where at most a step comes between two
    // More of a pass while there are pixels of other kinds among those that are decoded: axes that
    // wait for much room are accounted for in every pass.
    double round_unlike;
    double turn;         // more of a round for each call of the decoder
    double request;      // the longest request
    double request_byte; // requests of a saturated bus, for each byte on the bus
    // Interrupts: a step, one of a pulse train, an edge, a byte; share of all others.
    double step_isr, train_isr, edge_isr, byte_isr, other_isr_share;
};

struct guarantee_axis {
    const struct segment *entries; // runs of pixels, without marks
    uint32_t count;
    bool smooth;
    uint16_t backlash_steps;
    uint16_t line_speed; // V of the backlash
};

struct guarantee_board {
    uint32_t axes; // of the board: those that do not move cost nothing
    bool short_curves;
    double pixel_ticks; // the shortest that is declared
    uint32_t divider;
    uint32_t lead_edges; // of a locked line, else 0
    uint32_t more_edges; // of one that has begun
    // Of the bus: bytes while a frame is under way, bytes of frames and the rests between them.
    double bytes_per_tick, asked_per_tick;
    double round_ticks;  // that a round of several axes decodes for
    uint32_t most_calls; // of the decoder in it while the bus brings counts; 0: any
    double spare_ticks;  // that every part must be early by
    double margin;       // of all costs of the main loop: 1 and what their table misses
};

struct guarantee_verdict {
    bool follows;
    uint32_t axis;      // the first that is late
    uint32_t pixel;     // 1-based
    double late_ticks;  // how late
    double slack_ticks; // of all parts the least time to spare
    double busy;        // share of the time in which the main loop had something to do
};

// Add up what it costs to decode and to account for a line, looks not counted, interrupts excluded.
void guarantee_demand(const struct guarantee_costs *costs,
                      const struct guarantee_board *board,
                      const struct guarantee_axis *line,
                      double *decode,
                      double *account);

// Replay the lines. `line` has `lines` axes.
void guarantee_judge(const struct guarantee_costs *costs,
                     const struct guarantee_board *board,
                     const struct guarantee_axis *line,
                     uint32_t lines,
                     struct guarantee_verdict *verdict);
