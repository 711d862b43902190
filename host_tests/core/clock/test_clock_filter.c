// SPDX-License-Identifier: MIT
#include <stdint.h>

#include "clock/clock_filter.h"
#include "fakes/chance.h"
#include "unity.h"

#define PERIOD_TICKS ((uint32_t)533333) // 30 Hz at 16 MHz
#define HOLD_OVER    4u
#define NOISE_TICKS  120 // evenly distributed up to so many
#define NOISY_EDGES  12000u

static struct clock_filter filter;
static uint32_t edge_ticks;

static void aim(uint32_t period_ticks, uint16_t edges_ahead)
{
    filter = (struct clock_filter){.hold_over = HOLD_OVER};
    clock_filter_aim(&filter, period_ticks, edges_ahead);
}

void setUp(void)
{
    chance_seed(1);
    edge_ticks = 0xFFF00000uL; // times wrap soon
    aim(PERIOD_TICKS, 2);
}

void tearDown(void)
{
}

static bool edge_after(uint32_t ticks)
{
    edge_ticks += ticks;
    return clock_filter_edge(&filter, edge_ticks);
}

static void edges(uint16_t count, uint32_t period_ticks)
{
    for (; count != 0; count--) {
        TEST_ASSERT_TRUE(edge_after(period_ticks));
    }
}

// A prediction of so many edges ahead is the true time, give or take a tick.
static void check_ahead(uint16_t ahead, uint32_t period_ticks)
{
    uint32_t expected = edge_ticks + ahead * period_ticks;

    TEST_ASSERT_INT32_WITHIN(
        1, 0, (int32_t)(clock_filter_ahead(&filter, ahead) - expected));
}

static void thirty_edges_settle(void)
{
    edges(29, PERIOD_TICKS);
    TEST_ASSERT_FALSE(clock_filter_settled(&filter));
    edges(1, PERIOD_TICKS);
    TEST_ASSERT_TRUE(clock_filter_settled(&filter));
    check_ahead(1, PERIOD_TICKS);
    check_ahead(10, PERIOD_TICKS);
}

static void an_offset_is_met_without_an_error(void)
{
    for (int8_t sign = -1; sign <= 1; sign = (int8_t)(sign + 2)) {
        uint32_t period = PERIOD_TICKS + (uint32_t)(sign * 5333);

        aim(PERIOD_TICKS, 2);
        edges(30, period);
        check_ahead(1, period);
        check_ahead(2, period);
        TEST_ASSERT_UINT32_WITHIN(1, period, filter.period.ticks);
    }
}

static void the_shift_follows_the_distance(void)
{
    const struct {
        uint16_t ahead;
        uint8_t shift;
    } rows[] = {
        {1, 2},
        {5, 2},
        {6, 3},
        {15, 3},
        {16, 4},
        {45, 4},
        {46, 5},
        {405, 6},
        {406, 7},
        {2000, 7},
    };

    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        aim(PERIOD_TICKS, rows[i].ahead);
        TEST_ASSERT_EQUAL_UINT8(rows[i].shift, filter.shift_final);
        edges((uint16_t)(8u << rows[i].shift), PERIOD_TICKS);
        TEST_ASSERT_TRUE(clock_filter_settled(&filter));
        TEST_ASSERT_EQUAL_UINT8(rows[i].shift, filter.shift);
    }
}

// Hundredths of the standard deviation of predictions over that of the clock's jitter.
static void check_gain(uint16_t aimed, uint16_t ahead, uint16_t hundredths)
{
    uint64_t squares = 0;

    aim(PERIOD_TICKS, aimed);
    for (uint16_t i = 0; i < NOISY_EDGES; i++) {
        int32_t noise = (int32_t)(chance() % (2u * NOISE_TICKS + 1u)) - NOISE_TICKS;

        edge_ticks += PERIOD_TICKS;
        TEST_ASSERT_TRUE(clock_filter_edge(&filter, edge_ticks + (uint32_t)noise));
        if (i >= 200u) {
            int32_t error = (int32_t)(clock_filter_ahead(&filter, ahead) - edge_ticks -
                                      ahead * PERIOD_TICKS);
            squares += (uint64_t)((int64_t)error * error);
        }
    }
    // The variance of the noise is a (a + 1) / 3. Half a per cent of gain^2 is random.
    uint32_t found = (uint32_t)(squares * 30000u / (NOISE_TICKS * (NOISE_TICKS + 1u)) /
                                (NOISY_EDGES - 200u));
    uint32_t expected = (uint32_t)hundredths * hundredths;

    TEST_ASSERT_UINT32_WITHIN(expected / 12u, expected, found);
}

// The model's gains (DESIGN.md, "The pixel clock").
static void noise_is_averaged_as_the_model_says(void)
{
    check_gain(2, 1, 47);
    check_gain(2, 2, 52);
    check_gain(2, 4, 60);
    check_gain(10, 10, 45);
}

// The largest error of predictions after the period has grown by 1000 ppm, in microseconds.
static void check_peak(uint16_t aimed, uint16_t ahead, uint16_t peak_us)
{
    const uint32_t longer = PERIOD_TICKS + 533u;
    uint32_t peak = 0;
    uint32_t made[16];

    aim(PERIOD_TICKS, aimed);
    edges(70, PERIOD_TICKS);
    for (uint16_t k = 0; k < 120u; k++) {
        made[k % 16u] = clock_filter_ahead(&filter, ahead);
        edges(1, longer);
        if (k + 1u >= ahead) {
            uint32_t late = edge_ticks - made[(k + 1u - ahead) % 16u];
            peak = late > peak && late < PERIOD_TICKS ? late : peak;
        }
    }
    TEST_ASSERT_UINT32_WITHIN(16u * peak_us / 40u, 16u * peak_us, peak);
}

static void a_jump_of_the_period_peaks_as_the_model_says(void)
{
    check_peak(2, 1, 89);
    check_peak(2, 2, 114);
    check_peak(2, 4, 168);
    check_peak(10, 10, 412);
}

// Edges of a period that is no whole number of ticks, in the middle of which `part_65536` of a tick
// are over; captured, they are whole ticks.
static void check_far_ahead(uint16_t ahead, uint32_t whole_ticks, uint16_t part_65536)
{
    uint32_t fraction = 0x8000u;

    aim(whole_ticks, ahead);
    for (uint16_t k = 0; k < 2500u; k++) {
        fraction += part_65536;
        TEST_ASSERT_TRUE(edge_after(whole_ticks + (fraction >> 16)));
        fraction &= 0xFFFFu;
        if (clock_filter_settled(&filter)) {
            uint32_t parts = (fraction + (uint32_t)ahead * part_65536 + 0x8000u) >> 16;
            uint32_t expected = edge_ticks + ahead * whole_ticks + parts;
            TEST_ASSERT_INT32_WITHIN(
                1, 0, (int32_t)(clock_filter_ahead(&filter, ahead) - expected));
        }
    }
}

// Corrections that were rounded down would make a long way ahead too short, by up to three ticks.
static void predictions_far_ahead_are_exact(void)
{
    const uint16_t ahead[] = {1, 6, 60, 135, 525, 1009};

    for (size_t i = 0; i < sizeof ahead / sizeof ahead[0]; i++) {
        check_far_ahead(ahead[i], 7920, 51910);
        check_far_ahead(ahead[i], 16000, 0);
        check_far_ahead(ahead[i], 16000, 18350);
        check_far_ahead(ahead[i], 5333, 21845);
    }
}

static void missing_edges_are_counted_and_bridged(void)
{
    edges(40, PERIOD_TICKS);
    uint16_t number = filter.edge;

    TEST_ASSERT_TRUE(edge_after((HOLD_OVER + 1u) * PERIOD_TICKS));
    TEST_ASSERT_EQUAL_UINT16(HOLD_OVER, filter.missing);
    TEST_ASSERT_EQUAL_UINT16((uint16_t)(number + HOLD_OVER + 1u), filter.edge);
    check_ahead(2, PERIOD_TICKS);
}

static void no_edge_is_missing_before_the_first_one(void)
{
    TEST_ASSERT_FALSE(clock_filter_bridge(&filter));
    edges(1, PERIOD_TICKS);
    TEST_ASSERT_TRUE(clock_filter_bridge(&filter));
    TEST_ASSERT_EQUAL_UINT16(1, filter.missing);
}

// The clock is off by 1 % and some edges are missing behind the first `before` ones. Edges show it,
// or time does.
static void settle_beside_missing_edges(uint8_t before, uint8_t missing, bool by_time)
{
    const uint32_t period = PERIOD_TICKS + PERIOD_TICKS / 100u;

    aim(PERIOD_TICKS, 2);
    edges(before, period);
    edge_ticks += missing * period;
    if (by_time) {
        TEST_ASSERT_TRUE(clock_filter_bridge(&filter));
    }
    for (uint8_t left = 60; left != 0 && !clock_filter_settled(&filter); left--) {
        edges(1, period);
    }
    TEST_ASSERT_TRUE(clock_filter_settled(&filter));
    check_ahead(1, period);
    check_ahead(2, period);
}

static void missing_edges_while_it_settles_leave_nothing_behind(void)
{
    for (uint8_t before = 1; before < 29u; before++) {
        for (uint8_t missing = 1; missing <= HOLD_OVER; missing++) {
            settle_beside_missing_edges(before, missing, false);
            settle_beside_missing_edges(before, missing, true);
        }
    }
}

static void too_many_missing_edges_are_not_bridged(void)
{
    edges(40, PERIOD_TICKS);
    TEST_ASSERT_TRUE(edge_after((HOLD_OVER + 2u) * PERIOD_TICKS));
    TEST_ASSERT_EQUAL_UINT8(CLOCK_FILTER_FRESH_EDGES, filter.fresh);
}

// The period outlives a rest of any length; the first edge after it gives the phase.
static void a_clock_that_rests_keeps_its_period(void)
{
    uint32_t period = PERIOD_TICKS + 1234u;

    edges(40, period);
    uint16_t number = filter.edge;
    clock_filter_rest(&filter);
    TEST_ASSERT_TRUE(clock_filter_settled(&filter));
    TEST_ASSERT_FALSE(clock_filter_bridge(&filter)); // nothing is expected
    TEST_ASSERT_TRUE(edge_after(37u * PERIOD_TICKS + 200000u));
    TEST_ASSERT_EQUAL_UINT16((uint16_t)(number + 1u), filter.edge);
    for (uint8_t left = CLOCK_FILTER_FRESH_EDGES; left != 0; left--) {
        TEST_ASSERT_EQUAL_UINT8(left, filter.fresh);
        check_ahead(1, period);
        check_ahead(10, period);
        edges(1, period);
    }
    TEST_ASSERT_EQUAL_UINT8(0, filter.fresh);
}

// Nobody can tell which of the first two edges after a rest was the false one.
static void a_false_edge_after_a_rest_begins_the_rest_again(void)
{
    edges(40, PERIOD_TICKS);
    clock_filter_rest(&filter);
    edges(1, 7u * PERIOD_TICKS);
    TEST_ASSERT_FALSE(edge_after(PERIOD_TICKS / 3u));
    TEST_ASSERT_EQUAL_UINT8(CLOCK_FILTER_RESTS, filter.fresh);
    edges(1, PERIOD_TICKS);
    TEST_ASSERT_EQUAL_UINT8(CLOCK_FILTER_FRESH_EDGES, filter.fresh);
    check_ahead(1, PERIOD_TICKS);
}

static void a_rest_while_it_settles_begins_anew(void)
{
    edges(20, PERIOD_TICKS);
    clock_filter_rest(&filter);
    edges(29, PERIOD_TICKS);
    TEST_ASSERT_FALSE(clock_filter_settled(&filter));
    edges(1, PERIOD_TICKS);
    TEST_ASSERT_TRUE(clock_filter_settled(&filter));
}

// Edges of a clock whose period is so many hundredths of the filter's, until the filter has
// unsettled. Returns their number; 100: it has not.
static uint8_t edges_until_unsettled(uint16_t hundredths, uint16_t phase_hundredths)
{
    uint32_t period = PERIOD_TICKS / 100u * hundredths;

    aim(PERIOD_TICKS, 2);
    edges(60, PERIOD_TICKS);
    edge_ticks += PERIOD_TICKS / 100u * phase_hundredths;
    for (uint8_t count = 0; count < 100u; count++) {
        bool off =
            filter.period.ticks - PERIOD_TICKS + PERIOD_TICKS / 100u > PERIOD_TICKS / 50u;
        if (!clock_filter_settled(&filter) || filter.fresh != 0 || off) {
            return count;
        }
        (void)edge_after(period);
    }
    return 100;
}

// The most edges of such a clock, of all phases.
static uint8_t most_edges_of(uint16_t hundredths)
{
    uint8_t most = 0;

    for (uint16_t phase = 0; phase < 100u; phase += 7u) {
        uint8_t count = edges_until_unsettled(hundredths, phase);

        most = count > most ? count : most;
    }
    return most;
}

// Of any other frequency up to four times as fast or slow: the filter has unsettled, has lost its
// phase, or its period has left 1 % after 8 edges; 10 where it is off by less than 10 % and its
// phase has jumped as well.
static void another_clock_is_known_by_its_edges(void)
{
    for (uint16_t hundredths = 24; hundredths <= 420u; hundredths++) {
        if (hundredths > 96u && hundredths < 104u) {
            continue;
        }
        uint8_t most = hundredths > 90u && hundredths < 110u ? 10 : 8;

        TEST_ASSERT_LESS_OR_EQUAL_UINT8(most, most_edges_of(hundredths));
    }
}

// One edge of seven is missing, one of forty has a false one behind it.
static void noisy_edge(void)
{
    bool taken = edge_after((chance() % 7u == 0 ? 2u : 1u) * PERIOD_TICKS);
    bool is_false = chance() % 40u == 0;

    TEST_ASSERT_TRUE(taken);
    if (is_false) {
        TEST_ASSERT_FALSE(clock_filter_edge(&filter, edge_ticks + PERIOD_TICKS / 2u));
    }
}

static void noise_is_not_another_clock(void)
{
    edges(40, PERIOD_TICKS);
    for (uint16_t i = 0; i < NOISY_EDGES; i++) {
        noisy_edge();
    }
    TEST_ASSERT_TRUE(clock_filter_settled(&filter));
    TEST_ASSERT_EQUAL_UINT8(0, filter.fresh);
}

static void a_restart_begins_anew(void)
{
    edges(40, PERIOD_TICKS);
    clock_filter_restart(&filter);
    TEST_ASSERT_FALSE(clock_filter_settled(&filter));
    edges(30, PERIOD_TICKS);
    TEST_ASSERT_TRUE(clock_filter_settled(&filter));
}

static void time_can_bridge_an_edge_before_the_next_one_comes(void)
{
    edges(40, PERIOD_TICKS);
    uint16_t number = filter.edge;

    TEST_ASSERT_TRUE(clock_filter_bridge(&filter));
    TEST_ASSERT_TRUE(edge_after(2u * PERIOD_TICKS));
    TEST_ASSERT_EQUAL_UINT16((uint16_t)(number + 2u), filter.edge);
    TEST_ASSERT_EQUAL_UINT16(1, filter.missing);
    TEST_ASSERT_EQUAL_UINT8(0, filter.bridged);
}

static void glitches_are_counted_and_change_nothing(void)
{
    edges(40, PERIOD_TICKS);
    struct clock_filter before = filter;

    for (uint32_t part = PERIOD_TICKS / 100u; part < PERIOD_TICKS * 74uL / 100u;
         part += PERIOD_TICKS * 36uL / 100u) {
        TEST_ASSERT_FALSE(clock_filter_edge(&filter, edge_ticks + part));
        before.glitches++;
        before.doubt = (uint8_t)((before.doubt & 0x7Fu) + CLOCK_FILTER_DOUBT_FALSE);
    }
    TEST_ASSERT_EQUAL_MEMORY(&before, &filter, sizeof filter);
    edges(1, PERIOD_TICKS);
    TEST_ASSERT_EQUAL_INT32(0, filter.error_ticks);
}

static void a_false_first_edge_is_given_up(void)
{
    edges(1, 0);
    TEST_ASSERT_FALSE(edge_after(PERIOD_TICKS / 3u));
    edges(29, PERIOD_TICKS);
    TEST_ASSERT_FALSE(clock_filter_settled(&filter));
    edges(1, PERIOD_TICKS);
    TEST_ASSERT_TRUE(clock_filter_settled(&filter));
    check_ahead(2, PERIOD_TICKS);
}

// `before` edges, and behind them a false one; it may be so near that it passes for the edge whose
// neighbour it is.
static void settle_beside_a_false_edge(uint8_t before, uint32_t part_ticks)
{
    aim(PERIOD_TICKS, 2);
    edges(before, PERIOD_TICKS);
    (void)clock_filter_edge(&filter, edge_ticks + part_ticks);
    for (uint8_t left = 60; left != 0 && !clock_filter_settled(&filter); left--) {
        (void)edge_after(PERIOD_TICKS);
    }
    TEST_ASSERT_TRUE(clock_filter_settled(&filter));
    check_ahead(2, PERIOD_TICKS);
}

static void a_false_edge_while_it_settles_leaves_nothing_behind(void)
{
    for (uint8_t before = 1; before < 28u; before++) {
        for (uint32_t part = PERIOD_TICKS / 100u; part < PERIOD_TICKS;
             part += PERIOD_TICKS / 100u) {
            settle_beside_a_false_edge(before, part);
        }
    }
}

static void jitter_is_the_mean_error(void)
{
    edges(40, PERIOD_TICKS);
    TEST_ASSERT_UINT16_WITHIN(16, 0, filter.jitter);
    for (uint8_t i = 0; i < 200u; i++) {
        edges(1, PERIOD_TICKS + 100u);
        edges(1, PERIOD_TICKS - 100u);
    }
    // Edges are 50 ticks off to either side, and the filter follows them by a seventh.
    TEST_ASSERT_UINT16_WITHIN(100, 16u * 57u, filter.jitter);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(thirty_edges_settle);
    RUN_TEST(an_offset_is_met_without_an_error);
    RUN_TEST(the_shift_follows_the_distance);
    RUN_TEST(noise_is_averaged_as_the_model_says);
    RUN_TEST(a_jump_of_the_period_peaks_as_the_model_says);
    RUN_TEST(predictions_far_ahead_are_exact);
    RUN_TEST(missing_edges_are_counted_and_bridged);
    RUN_TEST(no_edge_is_missing_before_the_first_one);
    RUN_TEST(missing_edges_while_it_settles_leave_nothing_behind);
    RUN_TEST(too_many_missing_edges_are_not_bridged);
    RUN_TEST(a_clock_that_rests_keeps_its_period);
    RUN_TEST(a_false_edge_after_a_rest_begins_the_rest_again);
    RUN_TEST(a_rest_while_it_settles_begins_anew);
    RUN_TEST(another_clock_is_known_by_its_edges);
    RUN_TEST(noise_is_not_another_clock);
    RUN_TEST(a_restart_begins_anew);
    RUN_TEST(time_can_bridge_an_edge_before_the_next_one_comes);
    RUN_TEST(glitches_are_counted_and_change_nothing);
    RUN_TEST(a_false_first_edge_is_given_up);
    RUN_TEST(a_false_edge_while_it_settles_leaves_nothing_behind);
    RUN_TEST(jitter_is_the_mean_error);
    return UNITY_END();
}
