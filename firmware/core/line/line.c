// SPDX-License-Identifier: MIT
#include "line/line.h"

#include "base/apart.h"     // APART
#include "base/divide.h"    // divide_u32_u16
#include "base/multiply.h"  // multiply_u32_u16
#include "build_features.h" // FEATURE_*

// True until the backlash steps are made: the line's pieces run ahead of the pixel edges.
static inline bool is_shifted(const struct line *line)
{
    return FEATURE_BACKLASH && line->source.shifted;
}

APART_LARGE void line_begin(struct line *line,
                            const struct pixel_period *period,
                            struct segment_queue *queue)
{
    *line = (struct line){0};
    struct segment parameter = segment_source_begin(&line->source, queue);
    uint16_t backlash_steps = (uint16_t)parameter.count & SEGMENT_PARAMETER;

    if (backlash_steps != 0) {
        line->line_speed = parameter.repeat;
        line_take_up(line, backlash_steps);
    }
    line->source.fresh = true;
    line->source.edge_open = true;
    line_grid_start_exact(&line->edges, period);
}

// Ticks from the start of the next piece to the next pixel edge. A locked line's edge is fixed
// here, so as late as possible.
static APART uint32_t ticks_to_edge(struct line *line)
{
    if (line->source.edge_open) {
        line->source.edge_open = false;
        line->to_edge_ticks += line_grid_advance(&line->edges);
    }
    return line->to_edge_ticks;
}

static APART int16_t position_after(const struct line *line,
                                    const struct piece *piece,
                                    uint16_t steps)
{
    uint16_t position = (uint16_t)line->position;

    return (int16_t)(uint16_t)(piece->negative ? position - steps : position + steps);
}

// Place the next pixel edge in this piece, after edge_steps of the piece's steps.
static APART void place_edge(struct line *line, struct piece *piece, uint16_t edge_steps)
{
    piece->has_edge = true;
    piece->edge_steps = edge_steps;
    piece->edge_ticks = ticks_to_edge(line);
    piece->edge_position = position_after(line, piece, edge_steps);
    line->to_edge_ticks = piece->edge_ticks - piece->ticks;
    line->source.edge_open = true;
}

// The part t_b of a pixel by which the line runs ahead of it.
static APART uint32_t ticks_ahead(const struct line *line, uint32_t ticks)
{
    return pixel_share_ticks(ticks, line->backlash_steps, line->line_speed);
}

// Move the line's position by the steps of this piece.
static void count_steps(struct line *line, const struct piece *piece)
{
    line->position = position_after(line, piece, piece->steps);
}

// Make the start of the leading zero pixel, a piece without steps. False when the backlash equals
// the line speed: the piece would have no length.
static bool delay_piece(struct line *line, struct piece *piece)
{
    uint32_t edge_ticks = ticks_to_edge(line);
    uint32_t ticks = line_grid_locked(&line->edges)
                         ? edge_ticks - ticks_ahead(line, edge_ticks)
                         : pixel_grid_start_shifted(&line->pieces,
                                                    line->edges.exact.period,
                                                    line->backlash_steps,
                                                    line->line_speed);

    *piece = (struct piece){.ticks = ticks, .negative = line->source.negative};
    line->to_edge_ticks -= ticks;
    segment_source_pass_pixel(&line->source);
    return ticks != 0;
}

// Make the backlash take-up: the backlash steps, at line speed, up to the next pixel edge.
static void take_up_piece(struct line *line, struct piece *piece)
{
    *piece = (struct piece){
        .ticks = ticks_to_edge(line),
        .steps = line->backlash_steps,
        .negative = line->source.negative,
    };
    line->source.shifted = false;
    place_edge(line, piece, piece->steps);
    count_steps(line, piece);
}

// Steps that a shifted pixel has made when its fraction f = backlash/line_speed = B/V has passed:
// the floor of v0*f + h*f*f = B*(v0*V + h*B) / (V*V) in exact arithmetic. The code divides by V
// twice, the first time before the product grows beyond 32 bits.
static APART uint16_t steps_at_edge(const struct line *line, uint16_t steps)
{
    uint16_t backlash = line->backlash_steps;
    uint16_t whole = line->line_speed;
    int32_t half = (int32_t)steps - line->speed;
    uint32_t sum =
        multiply_u32_u16(line->speed, whole) + multiply_u32_u16((uint32_t)half, backlash);
    uint16_t speed = divide_u32_u16(sum, whole);
    uint16_t rest = (uint16_t)(sum - multiply_u32_u16(speed, whole));
    uint32_t product = multiply_u32_u16(speed, backlash) +
                       divide_u32_u16(multiply_u32_u16(rest, backlash), whole);

    return divide_u32_u16(product, whole);
}

// The length of a pixel. Where a locked line runs ahead, its pixels end so far ahead of the grid as
// t_b of the pixel to come says.
static uint32_t pixel_ticks(struct line *line)
{
    if (!is_shifted(line)) {
        return ticks_to_edge(line);
    }
    if (!line_grid_locked(&line->edges)) {
        return pixel_grid_advance(&line->pieces);
    }
    uint32_t next = line_grid_advance(&line->edges);

    line->next_ahead_ticks = ticks_ahead(line, next);
    return ticks_to_edge(line) + next - line->next_ahead_ticks;
}

// Place the pixel edge in a piece that runs ahead of it. In a locked line such a piece is not quite
// as long as its pixel: the edge is placed where the steps have it, in the same part of the piece.
static void place_edge_ahead(struct line *line, struct piece *piece)
{
    if (line_grid_locked(&line->edges)) {
        line->to_edge_ticks = ticks_ahead(line, piece->ticks);
    }
    place_edge(line, piece, steps_at_edge(line, piece->steps));
    if (line_grid_locked(&line->edges)) {
        line->to_edge_ticks = line->next_ahead_ticks;
        line->source.edge_open = false;
    }
}

static enum line_status pixel_piece(struct line *line, struct piece *piece)
{
    uint16_t steps = segment_source_steps(&line->source);

    if (line->source.smooth && 2u * steps < line->speed) {
        return LINE_DRY;
    }

    *piece = (struct piece){
        .ticks = pixel_ticks(line),
        .steps = steps,
        .start_speed = line->speed,
        .curved = line->source.smooth && steps != line->speed,
        .negative =
            line->source.smooth ? line->source.negative : line->source.segment.count < 0,
    };
    if (is_shifted(line)) {
        place_edge_ahead(line, piece);
    } else {
        place_edge(line, piece, steps);
    }
    count_steps(line, piece);
    line->speed = line->source.smooth ? (uint16_t)(2u * steps - line->speed) : steps;
    segment_source_pass_pixel(&line->source);
    return LINE_PIECE;
}

APART bool line_is_early(const struct line *line)
{
    // An edge that has its time already waits for nothing.
    return (is_shifted(line) || line->source.edge_open) &&
           line_grid_early(&line->edges, is_shifted(line));
}

_Static_assert((int)SEGMENTS_PIXELS == (int)LINE_PIECE &&
                   (int)SEGMENTS_DRY == (int)LINE_DRY &&
                   (int)SEGMENTS_OVER == (int)LINE_OVER,
               "take_segment() gives one as the other");

// Put a segment with pixels in work. LINE_PIECE: a piece can be made of it.
static APART_SMALL enum line_status take_segment(struct line *line)
{
    return (enum line_status)segment_source_next(&line->source, line->speed);
}

APART enum line_status line_next(struct line *line, struct piece *piece)
{
    if (is_shifted(line) && !line->source.fresh && line->speed == line->line_speed) {
        take_up_piece(line, piece);
        return LINE_PIECE;
    }
    enum line_status status = take_segment(line);
    if (status == LINE_PIECE && line->source.fresh) {
        line->source.fresh = false;
        if (is_shifted(line)) {
            if (delay_piece(line, piece)) {
                return LINE_PIECE;
            }
            status = take_segment(line);
        }
    }
    return status == LINE_PIECE ? pixel_piece(line, piece) : status;
}

bool line_on_pixels(const struct line *line)
{
    return !is_shifted(line) && !line->source.fresh &&
           !(FEATURE_HOMING && segment_source_ends_early(&line->source));
}

uint8_t line_even_steps(struct line *line, bool negative)
{
    segment_source_pixels(&line->source);
    uint16_t steps = line_many_steps(line, negative);

    if (steps == 0 || steps > UINT8_MAX) {
        return 0;
    }
    line->curve_half = 0;
    line->speed = steps;
    return (uint8_t)steps;
}

uint32_t line_known_ticks(struct line *line)
{
    return ticks_to_edge(line);
}

uint32_t line_pixel_ticks(struct line *line)
{
    return line_is_early(line) ? 0 : ticks_to_edge(line);
}
