// SPDX-License-Identifier: MIT
// Makes pieces of the segments of one line. A piece is a span of time with evenly spaced or
// uniformly accelerated steps. A piece is one pixel, except where backlash is taken up (DESIGN.md,
// "Counts to intervals, exactly"): there the pixels before the line speed V is reached lie
// t_b = P*B/V earlier than the clock, and a piece of B steps at speed V brings the line back onto
// the clock.
//
//     edges      0         1         2    ...   Na       Na+1      Na+2
//                |---------|---------|-- ... ---|---------|---------|
//     pieces     | delay |  n1     |  n2   ... |  nNa  | B |   V     |
//                        ^ 1 - B/V pixels
//
// Every pixel edge falls into exactly one piece; the piece names the number of its steps before the
// edge. decode.c takes pieces from line_next(). The writers of whole pixels ask the functions after
// line_on_pixels() instead, where a pixel needs no piece. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "clock/lock_grid.h"     // struct line_grid
#include "clock/pixel_period.h"  // struct pixel_grid
#include "line/even_rate.h"      // struct even_rate
#include "line/segment_source.h" // struct segment_source

// line_next() writes all members. The three about an edge mean nothing without has_edge.
struct piece {
    // Length of the piece, ticks, 1..2^24.
    uint32_t ticks;
    // Steps in the piece, 0..32767; 0: time without steps.
    uint16_t steps;
    // Speed at the start, steps/pixel; means something in curved pieces alone.
    uint16_t start_speed;
    // The steps have constant acceleration; else they are evenly spaced.
    bool curved;
    // Direction of the steps.
    bool negative;
    // A pixel edge falls into this piece, or lies at its end.
    bool has_edge;
    // Steps of the piece at or before that edge, 0..steps.
    uint16_t edge_steps;
    // Expected position at that edge: signed steps of the line, modulo 2^16.
    int16_t edge_position;
    // Ticks from the start of the piece to that edge (1..ticks).
    uint32_t edge_ticks;
};

// The line in work. line.c writes the members; the writers of whole pixels also write `even`,
// curve_half, `speed` and `room`, as their headers say.
struct line {
    // Where the segments come from, and the one in work. Three of its flags are the line's own:
    //
    //     shifted      the line is still ahead of the pixel clock, because backlash is not yet
    //                  taken up
    //     fresh        no piece was made yet
    //     edge_open    to_edge_ticks lacks a pixel that has no length yet
    struct segment_source source;
    // The interval of the last pixel of few even steps.
    struct even_rate even;
    // Half-acceleration of the pixel before, if curved_pixel.c wrote it; else 0. Steps/pixel^2.
    int16_t curve_half;
    // Steps B of play that this line takes up; 0: none.
    uint16_t backlash_steps;
    // Speed V of the backlash parameter, steps/pixel; 0: the line has no backlash.
    uint16_t line_speed;
    // Speed at the start of the next piece, steps/pixel; of a plain line, in the last pixel.
    uint16_t speed;
    // Signed steps of the line up to the start of the next piece, modulo 2^16.
    int16_t position;
    // From the start of the next piece to the next pixel edge, ticks.
    uint32_t to_edge_ticks;
    // Free entries of the ring that the next pixel of few even steps waits for; 0: it waits for
    // none. The decoder asks for no pixel before that many are free.
    uint8_t room;
    // The pixel edges.
    struct line_grid edges;
    union {
        // The ends of the shifted pieces.
        struct pixel_grid pieces;
        // Of a locked line: how far its next pixel runs ahead, ticks.
        uint32_t next_ahead_ticks;
    };
};

enum line_status {
    // A piece was made.
    LINE_PIECE,
    // The source has no segment for now, or the next one does not go on from the line's speed.
    LINE_DRY,
    // The source has no more segments.
    LINE_OVER,
};

// Begin a line that takes up all of its backlash, with the line's head at the queue's front as
// segment_source_begin() asks for it. period: exact length of a pixel, which must last and stay as
// long as the line.
void line_begin(struct line *line,
                const struct pixel_period *period,
                struct segment_queue *queue);

// Of a line that was begun and has made no piece: take up `steps` steps, at most the backlash
// parameter. With 0 the leading zero pixel stays idle.
static inline void line_take_up(struct line *line, uint16_t steps)
{
    line->backlash_steps = steps;
    line->source.shifted = steps != 0;
}

// Make the next piece of the line and count its steps in line->position. *piece is only valid with
// LINE_PIECE. After LINE_DRY the call may be repeated when the source has more. Only while
// line_is_early() is false. Divides in a line that is ahead of the clock.
enum line_status line_next(struct line *line, struct piece *piece);

// True where the line's pieces are the clock's own pixels, so that the functions below may be
// asked.
bool line_on_pixels(const struct line *line);

// Number of steps of the next pixel, 1..255, if they are evenly spaced and in this direction; 0:
// they are others, more than 255, or the source has no pixel by the quick way. May take the pixel's
// segment from the source. With a result above 0 the pixel's speed becomes the line's, because the
// caller is about to write the pixel.
uint8_t line_even_steps(struct line *line, bool negative);

// Number of steps of the next pixel if they are under acceleration; 0: they are not, no segment is
// in work, or the speed at the pixel's end would be negative. After line_even_steps(), which takes
// the segment and has found that the steps are not even.
static inline uint16_t line_curved_steps(const struct line *line)
{
    uint16_t steps = (uint16_t)line->source.segment.count;
    bool curved = line->source.smooth && line->source.segment.repeat != 0 &&
                  2u * steps >= line->speed;

    return curved ? steps : 0;
}

// Number of steps of the next pixel if they are evenly spaced and in this direction; 0: they are
// not, or no segment is in work. After line_even_steps(), which takes the segment.
static inline uint16_t line_many_steps(const struct line *line, bool negative)
{
    uint16_t steps = segment_source_steps(&line->source);
    bool even = line->source.smooth ? steps == line->speed
                                    : (line->source.segment.count < 0) == negative;

    return even && line->source.segment.repeat != 0 ? steps : 0;
}

// Length of the next pixel, ticks; 0 while line_is_early(). A locked line's pixel gets its length
// here, as late as possible, and keeps it. Only where line_on_pixels() is true.
uint32_t line_pixel_ticks(struct line *line);
// As line_pixel_ticks(), where the caller has asked line_is_early() already.
uint32_t line_known_ticks(struct line *line);

// Pass over one pixel of `steps` signed steps of the segment in work: line->position moves, and the
// next pixel comes. The caller has set line->speed. After line_pixel_ticks().
static inline void line_pass_even(struct line *line, int16_t steps)
{
    segment_source_pass_pixel(&line->source);
    line->position = (int16_t)(uint16_t)((uint16_t)line->position + (uint16_t)steps);
    line->to_edge_ticks = 0;
    line->source.edge_open = true;
}

// True when the next piece must not be made yet: the line is locked to the clock, and edges that
// are still to come will make the piece's end more certain. Always false of a line that is not
// locked, and of a piece whose end has its time already.
bool line_is_early(const struct line *line);
