// SPDX-License-Identifier: MIT
// Curves of random pieces, and of pieces at the limits of their decoders: which decoder makes them,
// in what batches, and every entry, as one number a kind. The C of this suite on the PC and the
// assembly on a board must do the same. A number that changes tells that a curve is decoded in
// another way; tools/checks/trace_numbers.py writes new numbers where that is meant.
#include <stdbool.h>
#include <stdint.h>

#include "fakes/chance.h"
#include "fakes/promise.h"
#include "fakes/trace.h"
#include "ring/step_ring.h"
#include "steps/curve.h"
#include "unity.h"

#define PIECES      150u
#define MANY        4000u // and so many more on the PC, which has the time
#define MOST_STEPS  200u  // of a piece
#define SPEED_MAX   32766u
#define TICKS_MAX   0x1000000uL
#define TICKS_LEAST 0x400uL

static struct step_ring ring;
static uint32_t steps_made;
static uint8_t kinds; // bit n: a piece of enum curve_flat_kind n

void setUp(void)
{
    promise_broken = 0;
    trace_begin();
    steps_made = 0;
    kinds = 0;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

static void see_state(const struct curve *curve)
{
    kinds = (uint8_t)(kinds | 1u << curve->kind);
    trace(curve->kind);
    if (curve->kind == CURVE_FLAT_NOT) {
        trace(curve->state.steep.good);
        trace(curve->state.steep.seen);
        trace_long(curve->state.steep.last_ticks);
        if (curve->state.steep.seen == 2) {
            trace_long((uint32_t)curve->state.steep.change);
        }
    } else {
        trace(curve->stays);
        trace(curve->state.flat.flat.top);
    }
}

static void see_batch(uint8_t slot, const struct curve_made *made)
{
    trace(made->steps);
    if (made->steps != 0) {
        trace_long(made->ticks);
    }
    for (uint8_t i = 0; i < made->steps; i++, slot++) {
        uint8_t high = i == 0 ? made->first_high : ring.high[slot];
        trace((uint16_t)(high << 8 | ring.low[slot]));
    }
}

// All steps of the piece but the last one, or the first of them, in batches of any length; single
// steps where a batch has none, and now and then.
static void see_piece(uint32_t ticks, uint16_t speed, uint16_t steps)
{
    static struct curve curve;
    uint16_t left = (uint16_t)(steps - 1u);
    uint8_t slot = (uint8_t)chance();

    curve_start(&curve, ticks, speed, steps);
    see_state(&curve);
    left = left < MOST_STEPS ? left : (uint16_t)MOST_STEPS;
    while (left != 0) {
        struct curve_made made = {.steps = 0};
        uint8_t count = (uint8_t)chance_between(1, left < 60u ? left : 60u);
        if (chance_between(0, 9) != 0) {
            curve_burst(&curve, &ring, slot, count, &made);
            see_batch(slot, &made);
        }
        if (made.steps == 0) {
            trace_long(curve_next(&curve));
            made.steps = 1;
        }
        see_state(&curve);
        slot = (uint8_t)(slot + made.steps);
        left = (uint16_t)(left - made.steps);
        steps_made += made.steps;
    }
}

// A piece from speed to speed, as a line may have it: neither below 0, and its intervals above 64
// ticks.
static void see_speeds(uint32_t ticks, uint32_t from, uint32_t to)
{
    uint32_t most = ticks / 64u < SPEED_MAX ? ticks / 64u : SPEED_MAX;

    from = from < most ? from : most;
    to = to < most ? to : most;
    uint16_t steps = (uint16_t)((from + to) / 2u);
    // The end speed is twice the steps less the start speed.
    if (steps != 0 && 2u * steps >= from) {
        see_piece(ticks, (uint16_t)from, steps);
    }
}

static uint32_t some_ticks(void)
{
    uint32_t ticks = (uint32_t)TICKS_LEAST << chance_between(0, 13);

    return ticks | chance_between(0, 0x3FF);
}

static void any_piece(void)
{
    uint32_t ticks = some_ticks();
    uint32_t most = ticks / 64u < SPEED_MAX ? ticks / 64u : SPEED_MAX;

    uint32_t from = chance_between(0, most);
    see_speeds(ticks, from, chance_between(1, most));
}

// Speeds so near each other that the curve is flat.
static void flat_piece(void)
{
    uint32_t ticks = some_ticks();
    uint32_t most = ticks / 80u < 4000u ? ticks / 80u : 4000u;
    uint32_t speed = chance_between(most / 4u + 1u, most + 1u);

    see_speeds(ticks, speed, speed + chance_between(0, speed / 8u + 2u) - speed / 16u);
}

// From rest, to rest, and from a very low speed.
static void piece_at_rest(void)
{
    uint32_t ticks = some_ticks();
    uint32_t speed = chance_between(1, 400);
    uint32_t low = chance_between(0, 3);

    if (chance_between(0, 1) == 0) {
        see_speeds(ticks, low, speed);
    } else {
        see_speeds(ticks, speed, low);
    }
}

// Largest speed, and speed times ticks, around the limits of each decoder.
static void piece_at_a_limit(void)
{
    static const uint16_t speeds[] = {
        1399, 1400, 1401, 2799, 2800, 2801, 8190, 8191, 8192};
    static const uint32_t slopes[] = {0x2A0000, 0x150000, 0x2A000000, 0x15000000};
    uint32_t speed = chance_between(0, 2) == 0 ? speeds[chance_between(0, 8)]
                                               : (uint32_t)1 << chance_between(8, 14);
    uint32_t ticks = slopes[chance_between(0, 3)] / speed;

    if (ticks >= TICKS_MAX / 256u) {
        ticks = TICKS_MAX / 256u - 1u;
    }
    ticks = 256u * ticks + chance_between(0, 2) - 1u;
    uint32_t other = speed - chance_between(0, speed / 100u);
    if (chance_between(0, 1) == 0) {
        see_speeds(ticks, speed, other);
    } else {
        see_speeds(ticks, other, speed);
    }
}

// An interval about as long as extrapolation goes, or as a period can be.
static void piece_of_long_intervals(void)
{
    static const uint16_t intervals[] = {0x7F00, 0x7FFF, 0x8000, 0xFB00, 0xFC00};
    uint32_t speed = chance_between(4, 400);
    uint32_t ticks =
        speed * intervals[chance_between(0, 4)] + chance_between(0, 400) - 200u;

    if (ticks <= TICKS_MAX) {
        see_speeds(ticks, speed, chance_between(speed / 2u, speed + speed / 2u));
    }
}

// A piece that slows down, whose interval changes by less than two ticks from step to step at its
// start and by more than four at its end: flat at first, then steep.
static void steepening_piece(void)
{
    uint32_t interval = chance_between(300, 1500);
    uint32_t ticks = interval * interval / chance_between(6, 8);
    uint32_t speed = ticks / interval;

    see_speeds(ticks, speed, speed * chance_between(60, 72) / 100u);
}

static void check(uint32_t wanted)
{
    TEST_ASSERT_EQUAL_HEX32(wanted, trace_number());
}

static void pieces(void (*piece)(void), uint32_t seed, uint32_t wanted, uint32_t many)
{
    chance_seed(seed);
    for (uint8_t left = PIECES; left != 0; left--) {
        piece();
    }
    TEST_ASSERT_TRUE(steps_made > 20u * PIECES);
    check(wanted);
#if defined(__AVR__)
    (void)many;
#else
    for (uint16_t left = MANY; left != 0; left--) {
        piece();
    }
    check(many);
#endif
}

static void any_pieces(void)
{
    pieces(any_piece, 0xC0A1uL, 0xBFC84EB3uL, 0x858AD00DuL);
}

static void flat_pieces(void)
{
    pieces(flat_piece, 0xC0A2uL, 0x6FDCC2A1uL, 0x88076EE3uL);
    TEST_ASSERT_TRUE((kinds & 1u << CURVE_FLAT_NARROW) != 0);
    TEST_ASSERT_TRUE((kinds & 1u << CURVE_FLAT_WIDE) != 0);
}

static void pieces_that_begin_or_end_at_rest(void)
{
    pieces(piece_at_rest, 0xC0A3uL, 0x232E285DuL, 0x8099C5A6uL);
    TEST_ASSERT_TRUE((kinds & 1u << CURVE_FLAT_NOT) != 0);
}

static void pieces_at_every_limit(void)
{
    pieces(piece_at_a_limit, 0xC0A4uL, 0x492073E4uL, 0xDAA9B4BCuL);
}

static void pieces_of_long_intervals(void)
{
    pieces(piece_of_long_intervals, 0xC0A5uL, 0xB601714CuL, 0x345C79EBuL);
}

static void pieces_that_become_steep(void)
{
    pieces(steepening_piece, 0xC0A6uL, 0x21EAEC73uL, 0xA1373BE5uL);
    TEST_ASSERT_TRUE((kinds & 1u << CURVE_FLAT_NOT) != 0);
}

// The limits of the flat decoders, one by one: speed times ticks in units of 2^8, and the speed.
static void check_kinds(uint32_t ticks,
                        uint16_t speed,
                        bool loose,
                        enum curve_flat_kind above)
{
    TEST_ASSERT_EQUAL(above, curve_flat_now(ticks, speed, loose));
    TEST_ASSERT_EQUAL(above == CURVE_FLAT_NOT ? CURVE_FLAT_WIDE : CURVE_FLAT_NARROW,
                      curve_flat_now(ticks - 1u, speed, loose));
}

static void flat_kinds_by_their_limits(void)
{
    check_kinds(0x2A0000, 256, false, CURVE_FLAT_WIDE);
    check_kinds(0x150000, 256, true, CURVE_FLAT_WIDE);
    check_kinds(0x1000000, 0x2A00, false, CURVE_FLAT_NOT);
    check_kinds(0x1000000, 0x1500, true, CURVE_FLAT_NOT);
    TEST_ASSERT_EQUAL(CURVE_FLAT_NARROW, curve_flat_now(200000, 2800, false));
    TEST_ASSERT_EQUAL(CURVE_FLAT_WIDE, curve_flat_now(200000, 2801, false));
    TEST_ASSERT_EQUAL(CURVE_FLAT_NARROW, curve_flat_now(200000, 1400, true));
    TEST_ASSERT_EQUAL(CURVE_FLAT_WIDE, curve_flat_now(200000, 1401, true));
}

static enum curve_flat_kind kind_between(uint32_t ticks,
                                         uint16_t from,
                                         uint16_t to,
                                         bool *stays)
{
    return curve_flat_kind(ticks, from, to, stays);
}

// The interval of the lower speed is 0xFB00 ticks at most, or the piece is not flat at its slow
// end.
static void flat_only_where_intervals_fit(void)
{
    bool stays = false;

    TEST_ASSERT_NOT_EQUAL(CURVE_FLAT_NOT,
                          kind_between(0xFB00uL * 100u, 100, 100, &stays));
    TEST_ASSERT_TRUE(stays);
    TEST_ASSERT_EQUAL(CURVE_FLAT_NOT,
                      kind_between(0xFB00uL * 100u + 1u, 100, 100, &stays));
    TEST_ASSERT_FALSE(stays);
}

// T * (change of speed) and the cube of the speed, both in units of 2^8: below the cube the
// interval changes by less than a tick from step to step, below four times the cube by less than
// four.
static void flat_as_long_as_the_change_is_small(void)
{
    // 256 * 256 * 256 / 256 = 0x10000 is the cube; times four, 0x40000.
    uint32_t loose_ticks = 0x400000uL; // with a change of 16: 0x40000
    bool stays = true;

    TEST_ASSERT_EQUAL(CURVE_FLAT_NOT, kind_between(loose_ticks, 256, 272, &stays));
    TEST_ASSERT_FALSE(stays);
    (void)kind_between(loose_ticks - 16u, 256, 272, &stays);
    TEST_ASSERT_TRUE(stays);
}

// Slower and slower: flat at first, if it is so at the higher speed.
static void flat_at_first(void)
{
    bool stays = true;

    TEST_ASSERT_NOT_EQUAL(CURVE_FLAT_NOT, kind_between(0x400000uL, 272, 256, &stays));
    TEST_ASSERT_FALSE(stays);
}

// Whether the limits are those of a change below one tick, or the looser ones.
static void limits_follow_the_change(void)
{
    // A cube of 0x10000 at speed 256, and a change of 8: growth 0x10000 at 0x200000 ticks.
    bool stays = false;
    uint32_t ticks =
        0x180000uL; // times 264 above the loose limit of the narrow kind, below the other

    TEST_ASSERT_EQUAL(CURVE_FLAT_NARROW, kind_between(ticks, 256, 264, &stays));
    TEST_ASSERT_TRUE(stays);
    TEST_ASSERT_EQUAL(CURVE_FLAT_WIDE, kind_between(ticks, 256, 268, &stays));
    TEST_ASSERT_TRUE(stays);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(any_pieces);
    RUN_TEST(flat_pieces);
    RUN_TEST(pieces_that_begin_or_end_at_rest);
    RUN_TEST(pieces_at_every_limit);
    RUN_TEST(pieces_of_long_intervals);
    RUN_TEST(pieces_that_become_steep);
    RUN_TEST(flat_kinds_by_their_limits);
    RUN_TEST(flat_only_where_intervals_fit);
    RUN_TEST(flat_as_long_as_the_change_is_small);
    RUN_TEST(flat_at_first);
    RUN_TEST(limits_follow_the_change);
    return UNITY_END();
}
