// SPDX-License-Identifier: MIT
// Steps under constant acceleration: known anchors and the inequality that
// defines a step's tick.
#include <stdbool.h>
#include <stdint.h>

#include "fakes/chance.h"
#include "fakes/worked_example.h"
#include "ring/step_ring.h"
#include "steps/curve.h"
#include "unity.h"

// A piece costs the simulated board about a second when all its 16383 steps are computed.
#ifdef __AVR__
#define RANDOM_PIECES      60u
#define RANDOM_FLAT_PIECES 40u
#define RANDOM_RAMPS       10u
#define RANDOM_STEEP       60u
#else
#define RANDOM_PIECES      3000u
#define RANDOM_FLAT_PIECES 4000u
#define RANDOM_RAMPS       3000u
#define RANDOM_STEEP       6000u
#endif
#define BATCH        48u
#define ANCHOR_TICKS 1000000uL

void setUp(void)
{
    chance_seed(0x5EED0003uL);
}

void tearDown(void)
{
}

static void check_anchors(uint16_t start_speed, const uint32_t *places, uint16_t steps)
{
    struct curve curve;
    uint32_t at = 0;

    curve_start(&curve, ANCHOR_TICKS, start_speed, steps);
    for (uint16_t k = 0; k + 1u < steps; k++) {
        at += curve_next(&curve);
        TEST_ASSERT_EQUAL_UINT32(places[k], at);
    }
}

static void anchors_from_rest(void)
{
    static const uint32_t places[] = {500000, 707107, 866026};

    check_anchors(0, places, 4);
}

static void anchors_to_rest(void)
{
    static const uint32_t places[] = {133975, 292894, 500000};

    check_anchors(8, places, 4);
}

static void anchors_of_the_second_pixel(void)
{
    static const uint32_t places[] = {
        118034,
        224745,
        322876,
        414214,
        500000,
        581139,
        658313,
        732051,
        802776,
        870829,
        936492,
    };

    check_anchors(8, places, 12);
}

// v0*T*t + h*t*t in 1/T^2 steps.
static int64_t travel(uint32_t ticks, uint16_t speed, uint16_t steps, uint32_t at)
{
    int64_t slope = (int64_t)speed * (int64_t)ticks;
    int64_t half = (int64_t)steps - speed;

    return (int64_t)at * (slope + half * (int64_t)at);
}

// Step k falls at this tick: the smallest tick that satisfies the inequality.
static void check_step(
    uint32_t ticks, uint16_t speed, uint16_t steps, uint16_t k, uint32_t at)
{
    int64_t wanted = (int64_t)ticks * (int64_t)ticks * k;

    TEST_ASSERT_TRUE(travel(ticks, speed, steps, at) >= wanted &&
                     travel(ticks, speed, steps, at - 1u) < wanted);
}

// Compare every `stride`-th step; all steps are part of the sum.
static void check_piece(uint32_t ticks, uint16_t speed, uint16_t steps, uint16_t stride)
{
    struct curve curve;
    uint32_t at = 0;

    curve_start(&curve, ticks, speed, steps);
    for (uint16_t k = 1; k < steps; k++) {
        at += curve_next(&curve);
        if (k % stride == 0 || k + 1u == steps) {
            check_step(ticks, speed, steps, k, at);
        }
    }
}

static void ramp_of_the_worked_example(void)
{
    uint16_t speed = 0;

    for (uint8_t i = 0; i < WORKED_RAMP_PX; i++) {
        uint16_t count = (uint16_t)worked_ramp[i];
        check_piece(533333uL + (i & 1u), speed, count, 3);
        speed = (uint16_t)(2u * count - speed);
    }
    TEST_ASSERT_EQUAL_UINT16(1000, speed);
}

static void last_pixel_to_rest(void)
{
    check_piece(533333uL, 8, 4, 1);
    check_piece(533333uL, 128, 64, 1);
    check_piece(533333uL, 2000, 1000, 7);
}

static void short_pieces(void)
{
    check_piece(1024, 0, 3, 1);
    check_piece(1024, 2, 1, 1);
    check_piece(1024, 6, 3, 1);
    check_piece(1024, 4, 9, 1);
    check_piece(2000, 0, 50, 1);
}

static void longest_piece(void)
{
    check_piece(0xFFFFFFuL, 0, 1, 1);
    check_piece(0xFFFFFFuL, 0, 100, 1);
    check_piece(0xFFFFFFuL, 200, 100, 1);
    check_piece(0xFFFFFFuL, 16000, 16383, 251);
    check_piece(0xFFFFFFuL, 0, 16383, 251);
    check_piece(0xFFFFFFuL, 32766, 16383, 251);
}

// The decoder with which a piece begins.
static enum curve_flat_kind kind(uint32_t ticks, uint16_t speed, uint16_t steps)
{
    struct curve curve;

    curve_start(&curve, ticks, speed, steps);
    return (enum curve_flat_kind)curve.kind;
}

// Pieces on both sides of the limits between the three decoders.
static void narrow_meets_wide(void)
{
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NARROW, kind(524288uL, 1341, 1342));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_WIDE, kind(524288uL, 1342, 1343));
    check_piece(524288uL, 1341, 1342, 5);
    check_piece(524288uL, 1342, 1343, 5);
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NARROW, kind(524288uL, 451, 561));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_WIDE, kind(524288uL, 452, 562));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NARROW, kind(524288uL, 671, 561));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_WIDE, kind(524288uL, 672, 562));
    check_piece(524288uL, 451, 561, 5);
    check_piece(524288uL, 452, 562, 5);
    check_piece(524288uL, 671, 561, 5);
    check_piece(524288uL, 672, 562, 5);
}

static void flat_meets_steep(void)
{
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NARROW, kind(524288uL, 300, 402));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NOT, kind(524288uL, 300, 403));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NARROW, kind(524288uL, 506, 403));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NOT, kind(524288uL, 300, 150));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NARROW, kind(524288uL, 500, 250));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_WIDE, kind(524288uL, 1000, 500));
    check_piece(524288uL, 300, 402, 5);
    check_piece(524288uL, 300, 403, 5);
    check_piece(524288uL, 506, 403, 5);
    check_piece(524288uL, 300, 150, 5);
    check_piece(524288uL, 500, 250, 5);
    check_piece(524288uL, 1000, 500, 5);
}

// Steep at one end, flat at the other.
static void between_flat_and_steep(void)
{
    struct curve curve;

    curve_start(&curve, 533333uL, 0, 500);
    for (uint16_t i = 1; i < 500; i++) {
        (void)curve_next(&curve);
    }
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_WIDE, curve.kind);
    curve_start(&curve, 533333uL, 1000, 500);
    for (uint16_t i = 1; i < 500; i++) {
        (void)curve_next(&curve);
    }
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NOT, curve.kind);
}

// Pieces at and beyond the fastest end for which 40 bits are enough.
static void too_wide_to_be_flat(void)
{
    check_piece(0xFFFFFFuL, 0, 2688, 5);
    check_piece(0xFFFFFFuL, 0, 2689, 5);
    check_piece(0xFFFFFFuL, 5378, 2689, 5);
}

// Hardly any acceleration.
static void flat_pieces(void)
{
    for (uint16_t steps = 1496; steps <= 1504; steps++) {
        check_piece(533333uL, 1500, steps, 31);
        check_piece(533334uL, 1000, (uint16_t)(steps - 500u), 31);
        check_piece(533333uL, 1593, (uint16_t)(steps + 93u), 31);
    }
}

// As the axis decodes: into a ring, most steps in batches. An 8-bit index reaches all of each half.
static struct step_ring ring;

static uint16_t interval_at(uint8_t slot)
{
    return (uint16_t)(ring.high[slot] * 256u + ring.low[slot] + 1u);
}

// A batch as the axis publishes it; what stands before and behind it must not change.
static struct curve_made next_batch(struct curve *curve, uint8_t slot, uint16_t left)
{
    uint8_t count = (uint8_t)chance_between(1, left < BATCH ? left : BATCH);
    uint8_t behind = (uint8_t)(slot + count);
    uint8_t last_low = ring.low[(uint8_t)(slot - 1u)];
    uint8_t next_low = ring.low[behind];
    uint8_t next_high = ring.high[behind];
    struct curve_made made;
    uint32_t sum = 0;

    ring.high[slot] = STEP_HIGH_EMPTY;
    curve_burst(curve, &ring, slot, count, &made);
    TEST_ASSERT_TRUE(made.steps <= count);
    TEST_ASSERT_EQUAL_UINT8(STEP_HIGH_EMPTY, ring.high[slot]);
    TEST_ASSERT_EQUAL_UINT8(last_low, ring.low[(uint8_t)(slot - 1u)]);
    TEST_ASSERT_EQUAL_UINT8(next_low, ring.low[behind]);
    TEST_ASSERT_EQUAL_UINT8(next_high, ring.high[behind]);
    if (made.steps != 0) {
        ring.high[slot] = made.first_high;
        for (uint8_t i = 0; i < made.steps; i++) {
            sum += interval_at((uint8_t)(slot + i));
        }
        TEST_ASSERT_EQUAL_UINT32(sum, made.ticks);
    }
    return made;
}

static void check_batches(uint32_t ticks, uint16_t speed, uint16_t steps)
{
    struct curve curve;
    struct curve_made made;
    uint32_t at = 0;
    uint8_t slot = (uint8_t)chance();

    curve_start(&curve, ticks, speed, steps);
    for (uint16_t k = 1; k < steps; k = (uint16_t)(k + made.steps)) {
        made = next_batch(&curve, slot, (uint16_t)(steps - k));
        for (uint8_t i = 0; i < made.steps; i++) {
            at += interval_at(slot);
            check_step(ticks, speed, steps, (uint16_t)(k + i), at);
            slot++;
        }
        if (made.steps == 0) {
            made.steps = 1;
            at += curve_next(&curve);
            check_step(ticks, speed, steps, k, at);
        }
    }
}

// Slowing down, batches get shorter; around 4096 ticks they may be longer than 8 bits count.
static void slowing_down_slowly(void)
{
    check_batches(3610074uL, 932, 786);
    check_batches(3610074uL, 884, 780);
    check_batches(9330147uL, 2749, 1878);
}

static void batches(void)
{
    check_batches(533333uL, 0, 4);
    check_batches(533333uL, 44, 86);
    check_batches(533334uL, 128, 64);
    check_batches(533333uL, 896, 948);
    check_batches(533333uL, 1500, 1498);
    check_batches(533333uL, 1000, 1200);
    check_batches(0xFFFFFFuL, 300, 200);
    check_batches(16000, 20, 30);
}

static void batches_take_most_steps(void)
{
    struct curve curve;
    struct curve_made made;

    curve_start(&curve, 533333uL, 896, 948);
    for (uint8_t i = 0; i < 19; i++) {
        curve_burst(&curve, &ring, (uint8_t)(48u * i), 48, &made);
        TEST_ASSERT_EQUAL_UINT8(48, made.steps);
    }
}

// No step in less than 60 ticks at the faster end.
static uint16_t random_steps(uint32_t ticks)
{
    uint32_t top = ticks / 120u;

    top = top > 3000u ? 3000u : top;
    if ((chance() & 3u) != 0 && top > 200u) {
        top = 200;
    }
    return (uint16_t)chance_between(1, top);
}

static void random_pieces(void)
{
    for (uint16_t i = 0; i < RANDOM_PIECES; i++) {
        uint32_t ticks = (i & 1u) != 0 ? chance_between(1024, 40000uL)
                                       : chance_between(100000uL, 0xFFFFFFuL);
        uint16_t steps = random_steps(ticks);
        uint16_t speed = (uint16_t)chance_between(0, 2uL * steps);
        check_piece(ticks, speed, steps, steps > 200u ? 13 : 1);
        if (steps <= 200u) {
            check_batches(ticks, speed, steps);
        }
    }
}

// A change of speed at which a piece is hardly flat any more, or the largest there may be.
static uint16_t flat_change(uint32_t ticks, uint16_t speed)
{
    uint64_t limit = ((uint64_t)speed * speed * speed * 4u + speed) / ticks;
    uint16_t most = speed > 1000u ? 1000u : speed;

    return limit < most ? (uint16_t)limit : most;
}

// Any length of piece, any speed up to a step in 60 ticks, any change of speed, up and down. Every
// step is compared with exact 64-bit arithmetic.
static void random_flat_pieces(void)
{
    for (uint16_t i = 0; i < RANDOM_FLAT_PIECES; i++) {
        uint32_t ticks = chance_between(1024, 0xFFFFFFuL >> (i % 13u));
        uint32_t top = ticks / 60u < 4000u ? ticks / 60u : 4000u;
        uint16_t low = (uint16_t)chance_between(1, top);
        uint16_t half = (uint16_t)chance_between(0, flat_change(ticks, low) / 2u);
        uint16_t high = (uint16_t)(low + 2u * half);
        if (half != 0 && (i & 1u) != 0) {
            check_batches(ticks, low, (uint16_t)(low + half));
        } else if (half != 0) {
            check_batches(ticks, high, (uint16_t)(low + half));
        }
    }
}

// Between a slow end and a fast one: steep here, flat there.
static void random_ramps(void)
{
    for (uint16_t i = 0; i < RANDOM_RAMPS; i++) {
        uint32_t ticks = chance_between(200000uL, 0xFFFFFFuL >> (i % 5u));
        uint16_t low = (uint16_t)chance_between(0, 300);
        uint16_t half = (uint16_t)chance_between(100, 500);
        uint16_t start = (i & 1u) != 0 ? (uint16_t)(low + 2u * half) : low;
        check_batches(ticks, start, (uint16_t)(low + half));
    }
}

// Steep from end to end: any length of piece, any acceleration, up to a step in 60 ticks.
static void random_steep_pieces(void)
{
    for (uint16_t i = 0; i < RANDOM_STEEP; i++) {
        uint32_t ticks = chance_between(1024, 0xFFFFFFuL >> (i % 13u));
        uint32_t top = ticks / 120u < 250u ? ticks / 120u : 250u;
        uint16_t steps = (uint16_t)chance_between(1, top);
        uint16_t speed = (uint16_t)chance_between(0, 2uL * steps);
        check_batches(ticks, speed, steps);
    }
}

// The pixels of a ramp and of its mirror image: the speed changes by `growth` in each pixel.
static void check_ramp_of_batches(uint32_t ticks, uint16_t growth, uint8_t pixels)
{
    for (uint16_t i = 0; i < pixels; i++) {
        uint16_t low = (uint16_t)(i * growth);
        uint16_t steps = (uint16_t)(low + growth / 2u);
        check_batches(ticks, low, steps);
        check_batches(ticks, (uint16_t)(low + growth), steps);
    }
}

// 100000 steps/s^2 in pixels of 1/30 s and 1/100 s, then 20000.
static void ramps_of_steep_pieces(void)
{
    check_ramp_of_batches(533333uL, 110, 4);
    check_ramp_of_batches(160000uL, 10, 13);
    check_ramp_of_batches(533333uL, 22, 8);
    check_ramp_of_batches(160000uL, 2, 20);
}

// The longest interval that a board may have to make, and the worst guesses.
static void slowest_steps(void)
{
    for (uint16_t steps = 2; steps <= 300; steps = (uint16_t)(2u * steps - 1u)) {
        check_batches(0xFFFFFFuL, 0, steps);
        check_batches(0xFFFFFFuL, (uint16_t)(2u * steps), steps);
        check_batches(0xFFFFFFuL, 1, steps);
        check_batches(0xFFFFFFuL, (uint16_t)(2u * steps - 1u), steps);
        check_batches(1024, 0, steps < 17u ? steps : 17);
    }
}

// The fastest steps for which 40 bits are enough, and none that are faster.
static void flat_and_wide(void)
{
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_WIDE, kind(0xFFFFFFuL, 5500, 6100));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_WIDE, kind(0xFFFFFFuL, 7000, 6000));
    check_batches(0xFFFFFFuL, 5500, 6100);
    check_batches(0xFFFFFFuL, 7000, 6000);
}

// At the fast end of these pieces 40 bits are not enough, and none of the pieces is flat.
static void steep_and_wide(void)
{
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NOT, kind(0xFFFFFFuL, 0, 5000));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NOT, kind(0xFFFFFFuL, 10000, 5000));
    TEST_ASSERT_EQUAL_INT(CURVE_FLAT_NOT, kind(0xFFFFFFuL, 5400, 8500));
    check_batches(0xFFFFFFuL, 0, 5000);
    check_batches(0xFFFFFFuL, 10000, 5000);
    check_batches(0xFFFFFFuL, 5400, 8500);
}

// Around multiples of 256 ticks both bytes of an entry change, to and fro.
static void intervals_around_a_page(void)
{
    for (uint16_t speed = 1030; speed <= 1050; speed += 4u) {
        check_batches(533333uL, speed, (uint16_t)(speed + 1u));
        check_batches(533333uL, speed, (uint16_t)(speed - 6u));
        check_batches(2 * 533333uL, speed, (uint16_t)(speed + 1u));
        check_batches(2 * 533333uL, speed, (uint16_t)(speed - 6u));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(anchors_from_rest);
    RUN_TEST(anchors_to_rest);
    RUN_TEST(anchors_of_the_second_pixel);
    RUN_TEST(ramp_of_the_worked_example);
    RUN_TEST(last_pixel_to_rest);
    RUN_TEST(short_pieces);
    RUN_TEST(longest_piece);
    RUN_TEST(narrow_meets_wide);
    RUN_TEST(flat_meets_steep);
    RUN_TEST(between_flat_and_steep);
    RUN_TEST(slowing_down_slowly);
    RUN_TEST(too_wide_to_be_flat);
    RUN_TEST(flat_pieces);
    RUN_TEST(batches);
    RUN_TEST(batches_take_most_steps);
    RUN_TEST(random_pieces);
    RUN_TEST(random_flat_pieces);
    RUN_TEST(random_ramps);
    RUN_TEST(random_steep_pieces);
    RUN_TEST(ramps_of_steep_pieces);
    RUN_TEST(slowest_steps);
    RUN_TEST(flat_and_wide);
    RUN_TEST(steep_and_wide);
    RUN_TEST(intervals_around_a_page);
    return UNITY_END();
}
