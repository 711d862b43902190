// SPDX-License-Identifier: MIT
// The account is the same whether waypoints are passed one by one or many at once,
// and whether by the assembly of a board or by the C that it stands for, in all of the memory. The
// same of an edge's place.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "account/ledger.h"
#include "account/records.h"
#include "fakes/chance.h"
#include "stream/stream.h"
#include "unity.h"

#include "twins/ledger_waypoint_twin.inc" // twin_ledger_pass_waypoints

#define TRIALS       2000u
#define TWIN_TRIALS  400u
#define FEW_PERIODS  40u // of a pixel, so that one alone is never taken in a row
#define MANY_PERIODS 120u

struct account {
    struct ledger ledger;
    struct stream stream;
};

static struct step_ring ring;
static struct account start;
static struct account at_once;
static struct account one_by_one;
static uint8_t pixels;

void setUp(void)
{
    chance_seed(7);
}

void tearDown(void)
{
    records_thin(1, UINT16_MAX);
}

static bool once_in(uint32_t times)
{
    return chance_between(1, times) == 1;
}

// Two of them are less than 2^31 apart.
static int32_t any_position(void)
{
    return (int32_t)chance_between(0, 0x3FFFFFFF) - 0x20000000;
}

#if FEATURE_CLOCK_STATISTICS
// Near the small limits or near the large ones.
static int32_t any_error(void)
{
    return once_in(2) ? (int32_t)chance_between(0, 8)
                      : (int32_t)chance_between(0, 9000) - 4500;
}
#endif

static void begin_ledger(void)
{
    static const uint16_t every[] = {1, 2, 5, 100, 1000};
    static const uint16_t errors[] = {0, 3, 300, 4000, UINT16_MAX};
    struct ledger *ledger = &start.ledger;

    ledger_reset(ledger, 1000);
    records_thin(every[chance_between(0, 4)], errors[chance_between(0, 4)]);
    records_reset(&ledger->records);
    ledger->records.to_next = (uint16_t)chance_between(1, ledger->records.to_next);
    ledger->records.passing = once_in(2);
    ledger->records.count = 1;
    ledger->pulse = !once_in(16);
    ledger->negative = once_in(2);
    ledger->loaded_ticks = chance();
    ledger->position_steps = any_position();
    ledger->line_origin = any_position();
    ledger->pixel = chance();
    ledger->fresh = (uint8_t)chance_between(0, 3);
#if FEATURE_CLOCK_STATISTICS
    ledger->records.shown_ticks = (int16_t)any_error();
    for (uint8_t i = 0; i < RECORDS_EARLY; i++) {
        int32_t error_ticks = once_in(8) ? (int32_t)chance() : any_error();
        ledger->records.early_ticks[i] = once_in(2) ? (int16_t)error_ticks : 0;
    }
#endif
}

// Periods of any length from `slot` on. Returns how long they are together.
static uint32_t fill_ring(uint8_t slot, uint8_t count)
{
    uint32_t ticks = 0;

    for (; count != 0; count--, slot++) {
        uint16_t top = (uint16_t)chance_between(0, STEP_PERIOD_MAX_TICKS - 1u);
        ring.high[slot] = (uint8_t)(top >> 8);
        ring.low[slot] = (uint8_t)top;
        ticks += (uint32_t)top + 1u;
    }
    return ticks;
}

static uint8_t any_way(void)
{
    if (once_in(60)) {
        return once_in(2) ? 0 : WAYPOINT_START;
    }
    // A single axis notes no places.
    return SEVERAL_AXES && once_in(6) ? WAYPOINT_PLACE : WAYPOINT_PLAIN;
}

// So many pixels, as many as fit the ring; a deviation and a place now and then.
static void begin_stream(uint8_t most_periods)
{
    struct stream *stream = &start.stream;
    uint16_t periods = 0;
    uint16_t steps = (uint16_t)(start.ledger.position_steps - start.ledger.line_origin);

    stream->ring = &ring;
    stream->retired = (uint8_t)chance();
    stream->waypoint_tail = (uint8_t)chance();
    stream->delay_ticks = chance();
    uint32_t ticks = start.ledger.loaded_ticks - stream->delay_ticks;
    for (pixels = 0; pixels < STREAM_WAYPOINTS - 1u; pixels++) {
        uint8_t more = (uint8_t)chance_between(1, most_periods);
        if (periods + more > 252u) {
            break;
        }
        ticks += fill_ring((uint8_t)(stream->retired + periods), more);
        periods = (uint16_t)(periods + more);
        if (start.ledger.pulse) {
            steps = start.ledger.negative ? (uint16_t)(steps - more)
                                          : (uint16_t)(steps + more);
        }
        stream->waypoints[(uint8_t)(stream->waypoint_tail + pixels) &
                          (STREAM_WAYPOINTS - 1u)] = (struct waypoint){
            .slot = (uint8_t)(stream->retired + periods),
            .way = any_way(),
            .ticks_low = (uint16_t)ticks,
            .ticks_high = (uint8_t)(ticks >> 16),
            .position = (uint16_t)(steps + (once_in(40) ? 1u : 0u)),
        };
    }
    uint8_t end = (uint8_t)(stream->waypoint_tail + pixels);

    stream->waypoint_placed = once_in(4) ? (uint8_t)(end - 1u) : end;
    stream->waypoint_head = (uint8_t)(end + 1u);
    stream->plain = once_in(4) ? 0 : WAYPOINT_PLAIN;
}

static void take(struct account *account, uint8_t tail, bool *inside)
{
    *inside = ledger_pass_waypoints(&account->ledger, &account->stream, tail);
}

// The ends of pixels up to `tail`, in order, and then that itself.
static void take_one_by_one(uint8_t tail, bool *inside)
{
    const struct stream *stream = &start.stream;
    uint8_t made = (uint8_t)(tail - stream->retired);

    for (uint8_t i = 0; i < pixels; i++) {
        uint8_t slot = stream
                           ->waypoints[(uint8_t)(stream->waypoint_tail + i) &
                                       (STREAM_WAYPOINTS - 1u)]
                           .slot;
        if ((uint8_t)(slot - stream->retired) < made) {
            take(&one_by_one, slot, inside);
        }
    }
    take(&one_by_one, tail, inside);
}

static void compare(uint8_t most_periods)
{
    bool inside_at_once = false;
    bool inside = false;

    memset(&start, 0, sizeof start);
    begin_ledger();
    begin_stream(most_periods);
    memcpy(&at_once, &start, sizeof start);
    memcpy(&one_by_one, &start, sizeof start);
    uint8_t tail = (uint8_t)(start.stream.retired + chance_between(0, 252));

    take(&at_once, tail, &inside_at_once);
    take_one_by_one(tail, &inside);
    TEST_ASSERT_EQUAL(inside, inside_at_once);
    TEST_ASSERT_EQUAL_MEMORY(&one_by_one, &at_once, sizeof start);

    if (!once_in(6)) {
        return;
    }
    memcpy(&one_by_one, &start, sizeof start);
    inside = twin_ledger_pass_waypoints(&one_by_one.ledger, &one_by_one.stream, tail);
    TEST_ASSERT_EQUAL(inside, inside_at_once);
    TEST_ASSERT_EQUAL_MEMORY(&one_by_one, &at_once, sizeof start);
}

static void pixels_of_few_periods(void)
{
    for (uint16_t trial = 0; trial < TRIALS; trial++) {
        compare(FEW_PERIODS);
    }
}

static void pixels_of_many_periods(void)
{
    for (uint16_t trial = 0; trial < TRIALS; trial++) {
        compare(MANY_PERIODS);
    }
}

static void edges_and_periods_by_themselves(void)
{
    for (uint16_t trial = 0; trial < TWIN_TRIALS; trial++) {
        int32_t position = any_position();
        uint16_t expected = (uint16_t)(once_in(2) ? chance() : (uint32_t)position);
        uint8_t count = (uint8_t)chance();

        memset(&start, 0, sizeof start);
        begin_ledger();
        memcpy(&at_once, &start, sizeof start);
        memcpy(&one_by_one, &start, sizeof start);
        ledger_pass_periods(&at_once.ledger, count);
        ledger_pass_edge(&at_once.ledger, position, expected);
        twin_ledger_pass_periods(&one_by_one.ledger, count);
        twin_ledger_pass_edge(&one_by_one.ledger, position, expected);
        TEST_ASSERT_EQUAL_MEMORY(&one_by_one, &at_once, sizeof start);
    }
}

// The number of a pixel has 32 bits, also where its upper half changes.
static void numbers_of_pixels_wrap(void)
{
    static const uint32_t before[] = {0, 0xFFFEuL, 0x1FFFEuL, 0xFFFFFEuL, 0x7FFFFFFEuL};

    for (size_t i = 0; i < sizeof before / sizeof before[0]; i++) {
        for (uint8_t thinned = 0; thinned < 2u; thinned++) {
            memset(&start, 0, sizeof start);
            records_thin(thinned == 0 ? 1 : 1000, UINT16_MAX);
            ledger_reset(&start.ledger, 1000);
            records_reset(&start.ledger.records);
            start.ledger.pixel = before[i];
            start.ledger.pulse = true;
            start.stream.ring = &ring;
            uint32_t ticks = start.ledger.loaded_ticks;
            for (uint8_t k = 0; k < 4u; k++) {
                ticks += fill_ring((uint8_t)(60u * k), 60);
                start.stream.waypoints[k] =
                    (struct waypoint){.slot = (uint8_t)(60u * (k + 1u)),
                                      .way = WAYPOINT_PLAIN,
                                      .position = (uint16_t)(60u * (k + 1u)),
                                      .ticks_low = (uint16_t)ticks,
                                      .ticks_high = (uint8_t)(ticks >> 16)};
            }
            start.stream.waypoint_placed = 4;
            start.stream.waypoint_head = 5;
            (void)ledger_pass_waypoints(&start.ledger, &start.stream, 240);
            TEST_ASSERT_EQUAL_UINT32(before[i] + 4u, start.ledger.pixel);
        }
    }
}

// By the quick way and by the long one, which is the C of all places.
static uint32_t place(struct account *account,
                      bool quick,
                      const struct engine_sample *sample,
                      uint8_t back,
                      uint16_t ticks)
{
#if defined(__AVR__) && SEVERAL_AXES
    if (!quick) {
        return ledger_capture_anywhere(
            &account->ledger, &account->stream, sample, back, ticks);
    }
#else
    (void)quick;
#endif
    return ledger_advance_to_capture(
        &account->ledger, &account->stream, sample, back, ticks);
}

// A captured count: any one, or about as long as a period around this slot.
static uint16_t any_count(uint8_t slot)
{
    slot = (uint8_t)(slot - chance_between(0, 3));
    uint16_t ticks = (uint16_t)(ring.high[slot] << 8 | ring.low[slot]);

    return once_in(3) ? (uint16_t)chance_between(2, STEP_PERIOD_MAX_TICKS - 1u)
                      : (uint16_t)(ticks + chance_between(0, 4));
}

static void an_edge_among_periods_has_its_place(void)
{
    (void)fill_ring(0, 255);
    for (uint16_t trial = 0; trial < TWIN_TRIALS; trial++) {
        memset(&start, 0, sizeof start);
        begin_ledger();
        begin_stream(once_in(2) ? FEW_PERIODS : MANY_PERIODS);
        start.ledger.idle_seen = (uint16_t)chance();
        struct engine_sample sample = {
            .tail = (uint8_t)(start.stream.retired + chance_between(0, 60)),
            .cut = once_in(16),
            .idle_count =
                (uint16_t)(start.ledger.idle_seen + (once_in(16) ? chance() : 0)),
        };
        uint8_t back = (uint8_t)chance_between(0, 2);
        uint16_t ticks = any_count(sample.tail);
        memcpy(&at_once, &start, sizeof start);
        memcpy(&one_by_one, &start, sizeof start);

        uint32_t quick = place(&at_once, true, &sample, back, ticks);
        TEST_ASSERT_EQUAL_UINT32(place(&one_by_one, false, &sample, back, ticks), quick);
        TEST_ASSERT_EQUAL_MEMORY(&one_by_one, &at_once, sizeof start);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(pixels_of_few_periods);
    RUN_TEST(pixels_of_many_periods);
    RUN_TEST(edges_and_periods_by_themselves);
    RUN_TEST(numbers_of_pixels_wrap);
    RUN_TEST(an_edge_among_periods_has_its_place);
    return UNITY_END();
}
