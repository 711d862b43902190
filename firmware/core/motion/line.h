// SPDX-License-Identifier: MIT
// Makes pieces of the segments of one line. A piece is a span of time with evenly spaced or
// uniformly accelerated steps. A piece is one pixel, except where backlash is taken up (DESIGN.md,
// "Backlash"): there the pixels before the line speed V is reached lie t_b = P*B/V earlier than the
// clock, and a piece of B steps at speed V brings the line back onto the clock.
//
//     edges      0         1         2    ...   Na       Na+1      Na+2
//                |---------|---------|-- ... ---|---------|---------|
//     pieces     | delay |  n1     |  n2   ... |  nNa  | B |   V     |
//                        ^ 1 - B/V pixels
//
// Every pixel edge falls into exactly one piece; the piece names the number of its steps before the
// edge. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/lock_grid.h"     // struct line_grid
#include "motion/pixel_period.h"  // struct pixel_grid
#include "motion/segment_queue.h" // struct segment_queue

struct piece {
    // Length of the piece, ticks.
    uint32_t ticks;
    // Steps in the piece.
    uint16_t steps;
    // Speed at the start, steps/pixel; only of curved pieces.
    uint16_t start_speed;
    // Constant acceleration; else evenly spaced steps.
    bool curved;
    // Direction of the steps.
    bool negative;
    // A pixel edge falls into this piece,
    bool has_edge;
    // after so many of its steps
    uint16_t edge_steps;
    // and so many ticks from its start (1..ticks).
    uint32_t edge_ticks;
    // Position expected at the edge: signed steps of the line.
    int32_t edge_position;
};

struct line {
    // Where the segments come from.
    struct segment_queue *queue;
    // The segment being used; its repeat counts down.
    struct segment segment;
    // Pieces have constant acceleration; else one speed each.
    bool smooth : 1;
    bool negative : 1; // direction of a smooth line
    // The line is still ahead of the pixel clock, because backlash is not yet taken up.
    bool shifted : 1;
    // No piece was made yet.
    bool fresh : 1;
    // The line is a seek: it ends early when its switch trips.
    bool seek : 1;
    // The switch has tripped; segments are skipped up to one that slows down.
    bool leaving_out : 1;
    // The down mark was reached.
    bool down : 1;
    // to_edge_ticks lacks a pixel that has no length yet.
    bool edge_open : 1;
    // Steps B of play that this line takes up; 0: none.
    uint16_t backlash_steps;
    // Speed V of the backlash parameter, steps/pixel.
    uint16_t line_speed;
    uint16_t
        speed; // steps/pixel at the start of the next piece; plain: in the last pixel
    // Signed steps up to the start of the next piece.
    int32_t position;
    // From the start of the next piece to the next pixel edge, ticks.
    uint32_t to_edge_ticks;
    // The pixel edges.
    struct line_grid edges;
    union {
        // The ends of the shifted pieces,
        struct pixel_grid pieces;
        // and of a locked line how far its next pixel runs ahead, ticks.
        uint32_t next_ahead_ticks;
    };
};

enum line_status {
    // A piece was made.
    LINE_PIECE,
    // The queue is empty inside the line, or a seek's deceleration does not mirror its
    // acceleration.
    LINE_DRY,
    // The end mark was reached.
    LINE_OVER,
};

// Begin a line. The queue's front must be a start mark and its parameter; both are removed.
// take_up: insert the backlash (false: the leading zero pixel stays idle).
void line_begin(struct line *line,
                const struct pixel_period *period,
                struct segment_queue *queue,
                bool take_up);

// Make the next piece of the line and count its steps in line->position. *piece is only valid with
// LINE_PIECE. After LINE_DRY the call may be repeated when the queue has more.
enum line_status line_next(struct line *line, struct piece *piece);

// The next piece must not be made yet: the line is locked to the clock, and edges that are still to
// come will make the piece's end more certain.
bool line_is_early(const struct line *line);

// The switch of a seek has tripped: slow down from the next piece on.
void line_trip(struct line *line);
