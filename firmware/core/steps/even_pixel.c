// SPDX-License-Identifier: MIT
#include "steps/even_pixel.h"

#include "base/apart.h"  // BY_POINTER_SMALL
#include "base/divide.h" // divide_u32_u16
#include "base/flash.h"  // IN_FLASH
#include "line/line.h"   // struct line

// Where flash is short every quotient is a division.
#if SEVERAL_AXES
const uint16_t even_pixel_reciprocals[EVEN_PIXEL_MAX_STEPS + 1u] IN_FLASH = {
    0,    65535, 32768, 21845, 16384, 13107, 10922, 9362, 8192, 7281, 6553, 5957, 5461,
    5041, 4681,  4369,  4096,  3855,  3640,  3449,  3276, 3120, 2978, 2849, 2730, 2621,
    2520, 2427,  2340,  2259,  2184,  2114,  2048,  1985, 1927, 1872, 1820, 1771, 1724,
    1680, 1638,  1598,  1560,  1524,  1489,  1456,  1424, 1394, 1365, 1337, 1310, 1285,
    1260, 1236,  1213,  1191,  1170,  1149,  1129,  1110, 1092, 1074, 1057, 1040, 1024,
    1008, 992,   978,   963,   949,   936,   923,   910,  897,  885,  873,  862,  851,
    840,  829,   819,   809,   799,   789,   780,   771,  762,  753,  744,  736,  728,
    720,  712,   704,   697,   689,   682,   675,   668,  661,  655,  648,  642,  636,
    630,  624,   618,   612,   606,   601,   595,   590,  585,  579,  574,  569,  564,
    560,  555,   550,   546,
};

// ticks / steps of a pixel below 2^16 ticks. The reciprocal is at most one part in 65536 / n too
// small, so that the quotient is at most one too small.
static void divide_short(struct even_rate *rate, uint16_t ticks, uint8_t steps)
{
    uint16_t base =
        (uint16_t)((uint32_t)ticks * flash_word(&even_pixel_reciprocals[steps]) >> 16);
    uint8_t rest = (uint8_t)((uint8_t)ticks - (uint8_t)((uint8_t)base * steps));

    if (rest >= steps) {
        rest = (uint8_t)(rest - steps);
        base++;
    }
    *rate = (struct even_rate){ticks, base, steps, rest};
}
#else
static void divide_short(struct even_rate *rate, uint16_t ticks, uint8_t steps)
{
    (void)rate;
    (void)ticks;
    (void)steps;
}
#endif

bool even_pixel_divide(struct even_rate *rate, uint8_t steps, uint32_t ticks)
{
    BY_POINTER_SMALL(rate);
    if (SEVERAL_AXES && ticks <= UINT16_MAX) {
        divide_short(rate, (uint16_t)ticks, steps);
    } else if (ticks >> 16 >= steps) {
        return false;
    } else {
        uint16_t base = (uint16_t)ticks;
        // Where the clock is followed nearly every pixel of one step is another interval.
        if (steps != 1) {
            base = divide_u32_u16(ticks, steps);
        }
        uint8_t rest = (uint8_t)((uint8_t)ticks - (uint8_t)((uint8_t)base * steps));
        *rate = (struct even_rate){(uint16_t)ticks, base, steps, rest};
    }
    if (rate->base_ticks < EVEN_PIXEL_MIN_TICKS ||
        rate->base_ticks > EVEN_PIXEL_MAX_INTERVAL) {
        rate->steps = 0; // the next pixel must not take it for that of the last one
        return false;
    }
    return true;
}

#if !defined(__AVR__)

// Set the interval of a pixel. Where the last one had as many steps, the difference of their
// lengths goes to the remainder as far as the remainder can take it.
static bool set_interval(struct even_rate *rate, uint32_t ticks, uint8_t steps)
{
    uint16_t rest = (uint16_t)(rate->remainder + (uint16_t)ticks - rate->ticks);

    if (steps == rate->steps && rest < steps) {
        rate->ticks = (uint16_t)ticks;
        rate->remainder = (uint8_t)rest;
        return true;
    }
    return even_pixel_divide(rate, steps, ticks);
}

// Write the periods of the pixel. The interrupt sees all of them at once, by the store of the first
// one's high byte.
static void write_periods(const struct even_rate *rate,
                          struct step_ring *ring,
                          uint8_t slot)
{
    struct even even = {
        .base_ticks = rate->base_ticks,
        .remainder = rate->remainder,
        .steps = rate->steps,
        .sum = (uint16_t)(rate->steps - 1u),
    };
    uint8_t first = slot;
    uint8_t first_high = (uint8_t)((rate->base_ticks - (rate->remainder == 0)) >> 8);

    ring->high[(uint8_t)(slot + rate->steps)] = STEP_HIGH_EMPTY;
    for (uint8_t i = 0; i < rate->steps; i++, slot++) {
        uint16_t top = (uint16_t)(even_next(&even) - 1u);
        ring->low[slot] = (uint8_t)top;
        if (slot != first) {
            ring->high[slot] = (uint8_t)(top >> 8);
        }
    }
    ring->high[first] = first_high;
}

// Append the pixel, and a waypoint at its end.
static void even_pixel_put(struct stream *stream,
                           const struct even_rate *rate,
                           uint32_t ticks,
                           uint16_t position)
{
    uint8_t slot = stream->head;

    stream_put_pixel(stream,
                     rate->steps,
                     ticks,
                     (uint16_t)(rate->base_ticks + (rate->remainder != 0)),
                     position);
    write_periods(rate, stream->ring, slot);
}

// Write one pixel of the segment in work, of so many steps. Results as those of
// even_pixels_write().
static inline uint8_t write_pixel(struct line *line,
                                  struct stream *stream,
                                  uint8_t steps,
                                  bool negative)
{
    if (stream_waypoints_full(stream)) {
        return EVEN_PIXEL_WAITS;
    }
    if (steps > stream_space(stream)) {
        line->room = steps;
        return EVEN_PIXEL_WAITS;
    }
    uint32_t ticks = line_pixel_ticks(line);
    if (ticks == 0 || ticks > EVEN_PIXEL_MAX_TICKS ||
        !set_interval(&line->even, ticks, steps)) {
        return 0;
    }
    line_pass_even(line, (int16_t)(negative ? -steps : steps));
    even_pixel_put(stream, &line->even, ticks, (uint16_t)line->position);
    return (uint8_t)(EVEN_PIXEL_COST + steps / 4u);
}

uint8_t even_pixels_write(struct line *line,
                          struct stream *stream,
                          bool negative,
                          uint8_t budget)
{
    uint8_t spent = 0;
    uint8_t steps = 0;

    while (spent < budget) {
        if (spent == 0 || line->source.segment.repeat == 0) {
            steps = line_even_steps(line, negative);
            if (steps == 0 || steps > EVEN_PIXEL_MAX_STEPS) {
                return spent;
            }
        }
        uint8_t cost = write_pixel(line, stream, steps, negative);
        if (cost == 0 || cost == EVEN_PIXEL_WAITS) {
            return spent != 0 ? spent : cost;
        }
        spent = (uint8_t)(spent + cost);
    }
    return spent;
}

#endif
