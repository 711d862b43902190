// SPDX-License-Identifier: MIT
#include "steps/curved_pixel.h"

#include "base/apart.h"       // APART
#include "steps/even_pixel.h" // EVEN_PIXEL_*

// Cost of a pixel and of each step, in units of a step of a flat curve.
#define PIXEL_COST 40u
#define STEP_COST  3u
// Of a step that is found by itself, beyond that.
#define SLOW_STEP_COST 20u
#define MOST_COST      120u // as much as the whole budget of a call
// Longest pixel in which every interval fits a single period, ticks. In a longer one the speed must
// be such that no interval is longer than 2^15 ticks.
#define SHORT_PIXEL_TICKS 0xFC00u
#define LONG_PIXEL_SHIFT  15u

// True when every interval of the pixel is one single period, and not too short a one.
static bool intervals_fit(uint32_t ticks, uint16_t slowest, uint16_t fastest)
{
    return (ticks <= SHORT_PIXEL_TICKS || slowest > ticks >> LONG_PIXEL_SHIFT) &&
           ticks / EVEN_PIXEL_MIN_TICKS >= fastest;
}

// Make the next steps, at most `count`, into the ring from `slot` on, except for the high byte of
// the first. Returns what they cost beyond STEP_COST.
static uint8_t make_steps(struct curve_steep *steep,
                          struct step_ring *ring,
                          uint8_t slot,
                          uint8_t count,
                          struct curve_made *made)
{
    curve_steep_burst(steep, ring, slot, count, made);
    if (made->steps == 0) {
        uint32_t ticks = curve_steep_next(steep);
        uint16_t top = (uint16_t)(ticks - 1u);
        ring->low[slot] = (uint8_t)top;
        *made = (struct curve_made){ticks, 1, (uint8_t)(top >> 8)};
        return SLOW_STEP_COST;
    }
    return 0;
}

// Write the periods of the pixel, except for the high byte of the first, which is returned. The
// last step lies at the end of the pixel. *cost is increased up to MOST_COST.
static uint8_t write_periods(struct curve_steep *steep,
                             struct step_ring *ring,
                             uint8_t slot,
                             uint8_t steps,
                             uint32_t ticks,
                             uint8_t *cost)
{
    uint8_t first_high = 0;
    uint8_t left = (uint8_t)(steps - 1u);

    while (left != 0) {
        struct curve_made made;
        uint8_t more = make_steps(steep, ring, slot, left, &made);
        *cost = *cost < MOST_COST - more ? (uint8_t)(*cost + more) : MOST_COST;
        if (left == steps - 1u) {
            first_high = made.first_high;
        } else {
            ring->high[slot] = made.first_high;
        }
        slot = (uint8_t)(slot + made.steps);
        left = (uint8_t)(left - made.steps);
        ticks -= made.ticks;
    }
    uint16_t top = (uint16_t)(ticks - 1u);
    ring->low[slot] = (uint8_t)top;
    if (steps == 1u) {
        steep->good = false;
        return (uint8_t)(top >> 8);
    }
    ring->high[slot] = (uint8_t)(top >> 8);
    steep->change = (int32_t)ticks - (int32_t)steep->last_ticks;
    steep->last_ticks = ticks;
    return first_high;
}

// Begin the pixel. Where it goes on as the one before it ended, the next interval is extrapolated
// from that one's last two; else it is found from the speed.
static void begin(struct line *line,
                  struct curve_steep *steep,
                  uint32_t ticks,
                  int16_t half)
{
    struct curve_place at;

    curve_place_start(&at, ticks, line->speed, half);
    if (line->curve_half == half && steep->good) {
        steep->at = at;
    } else {
        curve_steep_start(steep, &at, ticks, line->speed);
    }
    line->curve_half = half;
}

APART uint8_t curved_pixel_write(struct line *line,
                                 struct curve_steep *steep,
                                 struct stream *stream)
{
    uint16_t steps = line_curved_steps(line);
    uint16_t end_speed = (uint16_t)(2u * steps - line->speed);
    bool faster = end_speed > line->speed;

    if (steps == 0 || steps > CURVED_PIXEL_MAX_STEPS || stream_waypoints_full(stream)) {
        return 0;
    }
    if (steps > stream_space(stream)) {
        return EVEN_PIXEL_WAITS;
    }
    uint32_t ticks = line_known_ticks(line);
    if (!intervals_fit(
            ticks, faster ? line->speed : end_speed, faster ? end_speed : line->speed)) {
        return 0;
    }
    uint8_t first = stream->head;
    begin(line, steep, ticks, (int16_t)(steps - line->speed));
    uint8_t cost = (uint8_t)(PIXEL_COST + STEP_COST * steps);
    uint8_t first_high =
        write_periods(steep, stream->ring, first, (uint8_t)steps, ticks, &cost);
    line_pass_even(line,
                   (int16_t)(line->source.negative ? -(int16_t)steps : (int16_t)steps));
    line->speed = end_speed;
    stream_put_pixel(
        stream,
        (uint8_t)steps,
        ticks,
        (uint16_t)((uint16_t)((uint16_t)(first_high << 8) | stream->ring->low[first]) +
                   1u),
        (uint16_t)line->position);
    stream->ring->high[first] = first_high;
    return cost;
}
