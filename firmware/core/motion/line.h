// SPDX-License-Identifier: MIT
// From the segments of one line to pieces: stretches of time with evenly spaced or uniformly
// accelerated steps. A piece is one pixel, except where backlash is taken up (spec 1.7): then the
// pixels before line speed V is reached lie t_b = P*B/V earlier than the clock, and a piece of B
// steps at V brings the line back onto it.
//
//     edges      0         1         2    ...   Na       Na+1      Na+2
//                |---------|---------|-- ... ---|---------|---------|
//     pieces     | delay |  n1     |  n2   ... |  nNa  | B |   V     |
//                        ^ 1 - B/V pixels
//
// Every pixel edge falls into exactly one piece; the piece says after how many of its steps.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/pixel_period.h"  // struct pixel_grid
#include "motion/segment_queue.h" // struct segment_queue

struct piece {
    uint32_t ticks;
    uint16_t steps;
    uint16_t start_speed;  // steps/pixel, meaningful when curved
    bool curved;           // constant acceleration; else evenly spaced
    bool negative;         // direction
    bool has_edge;         // a pixel edge falls into this piece,
    uint16_t edge_steps;   //   after so many of its steps
    uint32_t edge_ticks;   //   and so many ticks from its start (1..ticks)
    int32_t edge_position; // expected there: signed steps of the line up to that edge
};

struct line {
    struct segment_queue *queue;
    struct segment segment; // the segment now in work; repeat counts down
    bool smooth : 1;
    bool negative : 1;    // direction of a smooth line
    bool shifted : 1;     // still ahead of the pixel clock: backlash not yet taken up
    bool fresh : 1;       // no piece taken yet
    bool seek : 1;        // ends early when its switch trips:
    bool leaving_out : 1; // it has; segments up to one that slows down are left out
    bool down : 1;        // the down mark was taken
    uint16_t backlash_steps;
    uint16_t line_speed;
    uint16_t
        speed; // steps/pixel at the start of the next piece; plain: in the last pixel
    int32_t position;       // signed steps up to the start of the next piece
    uint32_t to_edge_ticks; // from the start of the next piece to the next pixel edge
    struct pixel_grid edges;
    struct pixel_grid pieces; // ends of the shifted pieces
};

enum line_status {
    LINE_PIECE, // a piece was made
    LINE_DRY, // the queue is empty inside the line, or a seek's way down does not mirror its way up
    LINE_OVER, // the end mark was taken
};

// The queue's front must be a start mark and its parameter; both are taken. take_up: insert the
// backlash (false: the leading zero pixel stays idle). Main loop only.
void line_begin(struct line *line,
                const struct pixel_period *period,
                struct segment_queue *queue,
                bool take_up);

enum line_status line_next(struct line *line, struct piece *piece);

// The switch of a seek has tripped: slow down from the next piece on.
void line_trip(struct line *line);
