// SPDX-License-Identifier: MIT
// Both ends of a stream: what the writer appends, the reader passes, once and in order.
#include <stddef.h>
#include <stdint.h>

#include "fakes/chance.h"
#include "fakes/promise.h"
#include "stream/stream.h"
#include "unity.h"

#define ROUNDS      3000u
#define FIRST_SLOT  250u // the ring wraps early
#define START_TICKS 8192u

static struct step_ring ring;
static struct pulse_train trains[STEP_TRAINS];
static struct stream stream;
static uint16_t
    lengths[STEP_RING_SLOTS]; // of the period that was appended last at each slot, ticks

void setUp(void)
{
    promise_broken = 0;
    chance_seed(0x5EED0013uL);
    stream.ring = &ring;
    stream.engine_trains = trains;
    stream_reset(&stream, FIRST_SLOT, START_TICKS);
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

static uint16_t random_ticks(void)
{
    return (uint16_t)chance_between(64, STEP_PERIOD_MAX_TICKS);
}

// Append `count` periods as a batch, the first of which becomes visible last.
static void put_batch(uint8_t count)
{
    uint8_t slot = stream.head;
    uint32_t sum = 0;

    for (uint8_t i = 0; i < count; i++) {
        uint8_t at = (uint8_t)(slot + i);
        lengths[at] = random_ticks();
        sum += lengths[at];
        (void)stream_write(&ring, at, lengths[at]);
    }
    uint8_t first_high = ring.high[slot];
    ring.high[slot] = STEP_HIGH_EMPTY;
    stream_publish_batch(&stream, count, sum, first_high);
}

static void put_periods(uint8_t count)
{
    for (; count != 0; count--) {
        lengths[stream.head] = random_ticks();
        stream_put_period(&stream, lengths[stream.head]);
    }
}

static uint32_t appended_ticks(uint8_t slot, uint8_t count)
{
    uint32_t sum = 0;

    for (; count != 0; count--) {
        sum += lengths[slot];
        slot++;
    }
    return sum;
}

// Pass periods up to the tail and compare their length with what was appended. Returns how many.
static uint8_t pass(uint8_t tail)
{
    uint8_t first = stream.retired;
    uint32_t ticks = 0;
    uint8_t count = stream_pass_periods(&stream, tail, &ticks);

    TEST_ASSERT_EQUAL_UINT8((uint8_t)(first + count), stream.retired);
    if (count != 0) {
        TEST_ASSERT_EQUAL_UINT32(appended_ticks(first, count), ticks);
    }
    return count;
}

static void check_waypoint(bool line_start, uint8_t early, uint16_t position)
{
    const struct waypoint *waypoint = stream_waypoint(&stream);

    if (!stream_has_waypoint(&stream)) {
        TEST_FAIL_MESSAGE("no waypoint");
        return;
    }
    TEST_ASSERT_EQUAL(line_start, waypoint->way >= WAYPOINT_START);
    TEST_ASSERT_EQUAL_UINT8(early, waypoint_early(waypoint));
    TEST_ASSERT_EQUAL_UINT16(position, waypoint->position);
}

static void new_stream_is_empty(void)
{
    TEST_ASSERT_EQUAL_UINT8(0, stream_used(&stream));
    TEST_ASSERT_EQUAL_UINT8(STEP_RING_CAPACITY, stream_space(&stream));
    TEST_ASSERT_EQUAL_HEX8(STEP_HIGH_EMPTY, ring.high[FIRST_SLOT]);
    TEST_ASSERT_EQUAL_UINT32(START_TICKS, stream.end_ticks);
    TEST_ASSERT_FALSE(stream_has_waypoint(&stream));
    TEST_ASSERT_TRUE(stream_train_free(&stream));
}

static void reset_forgets_everything(void)
{
    struct even even;

    even_start(&even, 100000, 100);
    put_batch(5);
    stream_add_waypoint(&stream, false, 5);
    TEST_ASSERT_EQUAL_UINT32(100000, stream_put_train(&stream, &even, 100));
    TEST_ASSERT_EQUAL_UINT32(100000, stream_put_train(&stream, &even, 100));
    TEST_ASSERT_FALSE(stream_train_free(&stream));
    stream_reset(&stream, 7, 99);
    TEST_ASSERT_EQUAL_UINT8(7, stream.head);
    TEST_ASSERT_EQUAL_UINT8(7, stream.retired);
    TEST_ASSERT_EQUAL_UINT32(99, stream.end_ticks);
    TEST_ASSERT_FALSE(stream_has_waypoint(&stream));
    TEST_ASSERT_FALSE(stream_on_plain_way(&stream, 9));
    TEST_ASSERT_EQUAL_UINT16(0, stream.trains[0].steps);
    TEST_ASSERT_EQUAL_UINT16(0, stream.trains[1].steps);
    TEST_ASSERT_EQUAL_HEX8(STEP_HIGH_EMPTY, ring.high[7]);
}

static void end_is_the_sum_of_all_entries(void)
{
    struct even even;

    even_start(&even, 100003, 300);
    put_periods(4);
    put_batch(10);
    uint32_t ticks = appended_ticks(FIRST_SLOT, 14);
    stream_put_command(&stream, STEP_COMMAND_QUIET);
    TEST_ASSERT_EQUAL_UINT32(100003, stream_put_train(&stream, &even, 300));
    TEST_ASSERT_EQUAL_UINT32(START_TICKS + ticks + 100003u, stream.end_ticks);
    stream_delay(&stream, STEP_IDLE_TICKS);
    TEST_ASSERT_EQUAL_UINT32(START_TICKS + ticks + 100003u + STEP_IDLE_TICKS,
                             stream_end_ticks(&stream));
}

// A train to the end of its piece needs no sum of its steps: everything else is alike.
static void the_rest_of_a_piece_is_a_train_like_others(void)
{
    static struct step_ring other_ring;
    struct even even;

    even_start(&even, 100003, 300);
    uint32_t before = even_skip(&even, 4);
    struct even at = even;
    TEST_ASSERT_EQUAL_UINT32(100003u - before, stream_put_train(&stream, &even, 296));
    struct pulse_train put = trains[0];
    struct stream_train noted = stream.trains[0];
    uint8_t head = stream.head;
    other_ring = ring;

    stream_reset(&stream, FIRST_SLOT, START_TICKS);
    stream_put_rest(&stream, &at, 296, 100003u - before);
    TEST_ASSERT_EQUAL_MEMORY(&put, &trains[0], sizeof(put));
    TEST_ASSERT_EQUAL_UINT16(noted.steps, stream.trains[0].steps);
    TEST_ASSERT_EQUAL_UINT16(noted.sum, stream.trains[0].sum);
    TEST_ASSERT_EQUAL_UINT8(head, stream.head);
    TEST_ASSERT_EQUAL_MEMORY(&other_ring, &ring, sizeof(ring));
}

static void put_pulse_train(uint16_t steps)
{
    struct even even;

    even_start(&even, 500u * steps, steps);
    (void)stream_put_train(&stream, &even, steps);
}

// The entries of a train are passed together: up to the interrupt, a waypoint or the other train.
static void entries_of_a_train_are_passed_together(void)
{
    put_pulse_train(300); // 127, 127, 46
    stream_add_waypoint(&stream, false, 1);
    put_pulse_train(400); // 127 up to the waypoint, 127, 127, 19
    TEST_ASSERT_EQUAL_UINT16(0, stream_pass_train(&stream, 0, FIRST_SLOT));
    TEST_ASSERT_EQUAL_UINT16(254,
                             stream_pass_train(&stream, 0, (uint8_t)(FIRST_SLOT + 2u)));
    TEST_ASSERT_EQUAL_UINT16(0, stream_pass_train(&stream, 1, stream.head));
    TEST_ASSERT_EQUAL_UINT16(46, stream_pass_train(&stream, 0, stream.head));
    TEST_ASSERT_EQUAL_UINT8((uint8_t)(FIRST_SLOT + 3u), stream.retired);
    TEST_ASSERT_EQUAL_UINT16(127, stream_pass_train(&stream, 1, stream.head));
    TEST_ASSERT_TRUE(stream_waypoint_within(&stream, 0));
    stream_pass_waypoint(&stream);
    TEST_ASSERT_EQUAL_UINT16(273, stream_pass_train(&stream, 1, stream.head));
    TEST_ASSERT_EQUAL_UINT8(stream.head, stream.retired);
}

// Which of two trains the interrupt makes is told by the entry before the one that it reads next.
static void the_older_train_is_known_by_its_entries(void)
{
    put_periods(2);
    put_pulse_train(200);
    put_periods(1);
    put_pulse_train(100);
    for (uint8_t taken = 1; taken <= stream_used(&stream); taken++) {
        uint8_t tail = (uint8_t)(FIRST_SLOT + taken);
        TEST_ASSERT_EQUAL(taken == 3 || taken == 4, stream_in_older_train(&stream, tail));
    }
}

static void reserved_slots_hide_what_follows(void)
{
    uint8_t held = stream_reserve(&stream, 3);

    put_periods(2);
    TEST_ASSERT_EQUAL_UINT8(FIRST_SLOT, held);
    TEST_ASSERT_EQUAL_HEX8(STEP_HIGH_EMPTY, ring.high[FIRST_SLOT]);
    TEST_ASSERT_EQUAL_UINT8((uint8_t)(FIRST_SLOT + 5u), stream.head);
    TEST_ASSERT_EQUAL_HEX8(STEP_HIGH_EMPTY, ring.high[stream.head]);
    TEST_ASSERT_EQUAL_UINT8(5, stream_used(&stream));
}

static void marks_wait_for_a_period(void)
{
    stream_add_waypoint(&stream, true, 0);
    stream_add_waypoint(&stream, false, 0xFFFE);
    TEST_ASSERT_TRUE(stream_waypoint_waits(&stream));
    TEST_ASSERT_FALSE(stream_has_waypoint(&stream));
    put_periods(1);
    TEST_ASSERT_FALSE(stream_waypoint_waits(&stream));
}

static void marks_are_read_behind_their_period(void)
{
    stream_add_waypoint(&stream, true, 0);
    stream_add_waypoint(&stream, false, 0xFFFE);
    put_periods(1);
    TEST_ASSERT_FALSE(stream_waypoint_within(&stream, 0));
    TEST_ASSERT_EQUAL_UINT8(1, pass(stream.head));
    TEST_ASSERT_TRUE(stream_waypoint_within(&stream, 0));
    check_waypoint(true, 0, 0);
    stream_pass_waypoint(&stream);
    check_waypoint(false, 0, 0xFFFE);
    stream_pass_waypoint(&stream);
    TEST_ASSERT_FALSE(stream_has_waypoint(&stream));
}

static void marks_fill_up(void)
{
    for (uint8_t i = 0; i < STREAM_WAYPOINTS - 1u; i++) {
        TEST_ASSERT_FALSE(stream_waypoints_full(&stream));
        stream_add_waypoint(&stream, false, i);
        put_periods(1);
    }
    TEST_ASSERT_TRUE(stream_waypoints_full(&stream));
    TEST_ASSERT_EQUAL_UINT8(1, pass(stream.head));
    stream_pass_waypoint(&stream);
    TEST_ASSERT_FALSE(stream_waypoints_full(&stream));
}

static void periods_end_at_marks_and_other_entries(void)
{
    put_periods(2);
    stream_add_waypoint(&stream, false, 2);
    stream_place_waypoints(&stream, 0);
    put_periods(3);
    stream_put_command(&stream, STEP_COMMAND_QUIET);
    put_periods(1);
    TEST_ASSERT_EQUAL_UINT8(2, pass(stream.head));
    stream_pass_waypoint(&stream);
    TEST_ASSERT_EQUAL_UINT8(3, pass(stream.head));
    TEST_ASSERT_EQUAL_HEX8(STEP_HIGH_COMMAND, stream_peek(&stream));
    TEST_ASSERT_EQUAL_HEX8(STEP_COMMAND_QUIET, stream_pass_entry(&stream));
    TEST_ASSERT_EQUAL_UINT8(1, pass(stream.head));
    TEST_ASSERT_EQUAL_UINT16(lengths[(uint8_t)(stream.retired - 1u)],
                             stream_passed_ticks(&stream, 1));
}

static void train_entries_name_their_train(void)
{
    struct even even;

    even_start(&even, 200000, 400);
    stream_add_waypoint(&stream, false, 0);
    TEST_ASSERT_EQUAL_UINT32(200000, stream_put_train(&stream, &even, 400));
    TEST_ASSERT_EQUAL_UINT32(200000, stream_put_train(&stream, &even, 400));
    check_waypoint(false, STEP_TRAIN_ENTRY_MAX - 1u, 0);
    for (uint8_t train = 0; train < STEP_TRAINS; train++) {
        int16_t steps = 0;
        for (uint8_t i = 0; i < 4; i++) {
            TEST_ASSERT_EQUAL_HEX8(STEP_HIGH_TRAIN, stream_peek(&stream));
            steps = (int16_t)(steps + (int8_t)stream_pass_entry(&stream));
        }
        TEST_ASSERT_EQUAL_INT16(train == 0 ? 400 : -400, steps);
        TEST_ASSERT_EQUAL_UINT16(500, stream_train_base(&stream, train));
        TEST_ASSERT_EQUAL_UINT32(50000, stream_train_ticks(&stream, train, 100));
        stream_free_train(&stream, train);
        TEST_ASSERT_TRUE(stream_train_free(&stream));
    }
    TEST_ASSERT_EQUAL_UINT8(0, stream_used(&stream));
}

// Waypoints behind a line's start.
static void begin_line(void)
{
    stream_add_waypoint(&stream, true, 0);
    stream_place_waypoints(&stream, 0);
    stream_pass_waypoint(&stream);
}

static void check_way(uint8_t slot, uint8_t way, uint32_t ticks)
{
    const struct waypoint *next = stream_waypoint(&stream);

    TEST_ASSERT_TRUE(stream_has_waypoint(&stream));
    TEST_ASSERT_EQUAL_UINT8((uint8_t)(FIRST_SLOT + slot), next->slot);
    TEST_ASSERT_EQUAL_HEX8(way, next->way);
    TEST_ASSERT_EQUAL_UINT32((START_TICKS + ticks) & 0xFFFFFFuL, waypoint_ticks(next));
    stream_pass_waypoint(&stream);
}

static void many_periods_end_at_a_place(void)
{
    begin_line();
    put_batch(10);
    TEST_ASSERT_FALSE(stream_has_waypoint(&stream));
    put_batch(30);
    put_batch(5);
    put_batch(30);
    check_way(40, WAYPOINT_PLACE, appended_ticks(FIRST_SLOT, 40));
    check_way(75, WAYPOINT_PLACE, appended_ticks(FIRST_SLOT, 75));
    TEST_ASSERT_FALSE(stream_has_waypoint(&stream));
}

// Pixel edges find room however many batches are written.
static void places_leave_room_for_edges(void)
{
    begin_line();
    for (uint8_t i = 0; i < 20u; i++) {
        put_batch(30);
    }
    TEST_ASSERT_TRUE((uint8_t)(stream.waypoint_head - stream.waypoint_tail) < 12u);
}

static void single_periods_lead_from_edge_to_edge(void)
{
    begin_line();
    put_periods(3);
    stream_add_waypoint(&stream, false, 3);
    put_periods(1);
    put_periods(2);
    stream_add_waypoint(&stream, false, 5);
    stream_place_waypoints(&stream, 0);
    check_way(4, WAYPOINT_PLAIN, appended_ticks(FIRST_SLOT, 4));
    check_way(6, WAYPOINT_PLAIN, appended_ticks(FIRST_SLOT, 6));
}

// An edge behind a command or in a train is reached entry by entry, and so is a line's start.
static void other_entries_are_no_plain_way(void)
{
    begin_line();
    put_periods(3);
    stream_put_command(&stream, STEP_COMMAND_QUIET);
    put_periods(1);
    stream_add_waypoint(&stream, false, 3);
    stream_place_waypoints(&stream, 0);
    stream_add_waypoint(&stream, true, 0);
    stream_add_waypoint(&stream, false, 3);
    put_pulse_train(300);
    put_periods(1);
    stream_add_waypoint(&stream, false, 4);
    stream_place_waypoints(&stream, 0);
    TEST_ASSERT_EQUAL_HEX8(0, stream_waypoint(&stream)->way);
    stream_pass_waypoint(&stream);
    TEST_ASSERT_EQUAL_HEX8(WAYPOINT_START | 126u, stream_waypoint(&stream)->way);
    stream_pass_waypoint(&stream);
    TEST_ASSERT_EQUAL_HEX8(126, stream_waypoint(&stream)->way);
    stream_pass_waypoint(&stream);
    TEST_ASSERT_EQUAL_HEX8(0, stream_waypoint(&stream)->way);
}

// The reader waits for a waypoint, written or not, but does not lag too many periods.
static void on_the_plain_way(void)
{
    uint8_t first = (uint8_t)(FIRST_SLOT + 3u);

    begin_line();
    put_periods(3);
    stream_add_waypoint(&stream, false, 3);
    stream_place_waypoints(&stream, 0);
    TEST_ASSERT_TRUE(stream_on_plain_way(&stream, (uint8_t)(first - 1u)));
    TEST_ASSERT_FALSE(stream_on_plain_way(&stream, first));
}

static void the_plain_way_ends_where_the_reader_lags(void)
{
    uint8_t last = (uint8_t)(FIRST_SLOT + STREAM_LAG_MOST - 1u);

    begin_line();
    put_periods(200);
    TEST_ASSERT_TRUE(stream_on_plain_way(&stream, last));
    TEST_ASSERT_FALSE(stream_on_plain_way(&stream, (uint8_t)(last + 1u)));
    stream_put_command(&stream, STEP_COMMAND_QUIET);
    TEST_ASSERT_FALSE(stream_on_plain_way(&stream, FIRST_SLOT));
}

// Waypoints know the time but for what comes before all of them.
static void a_delay_moves_no_waypoint(void)
{
    begin_line();
    put_batch(30);
    stream_delay(&stream, 0x12345678uL);
    put_batch(30);
    check_way(30, WAYPOINT_PLACE, appended_ticks(FIRST_SLOT, 30));
    check_way(60, WAYPOINT_PLACE, appended_ticks(FIRST_SLOT, 60));
    TEST_ASSERT_EQUAL_UINT32(START_TICKS + 0x12345678uL + appended_ticks(FIRST_SLOT, 60),
                             stream_end_ticks(&stream));
}

static void length_of_the_newest_train(void)
{
    struct even even;

    even_start(&even, 100003, 300);
    (void)stream_put_train(&stream, &even, 300);
    TEST_ASSERT_EQUAL_UINT32(100003, stream.newest_train_ticks);
}

// A command takes no time: the period before it is the newest one. The longest has a high byte next
// to the codes.
static void length_of_the_newest_period(void)
{
    struct even even;

    stream_put_period(&stream, STEP_PERIOD_MAX_TICKS);
    TEST_ASSERT_EQUAL_UINT16(STEP_PERIOD_MAX_TICKS, stream_newest_ticks(&stream));
    stream_put_period(&stream, 700);
    stream_put_command(&stream, STEP_COMMAND_QUIET);
    stream_put_command(&stream, STEP_COMMAND_NEGATIVE);
    TEST_ASSERT_EQUAL_UINT16(700, stream_newest_ticks(&stream));
    even_start(&even, 100003, 300);
    (void)stream_put_train(&stream, &even, 200);
    TEST_ASSERT_EQUAL_UINT16(333, stream_newest_ticks(&stream));
    even_start(&even, 50000, 100);
    (void)stream_put_train(&stream, &even, 100);
    stream_put_command(&stream, STEP_COMMAND_PULSE);
    TEST_ASSERT_EQUAL_UINT16(500, stream_newest_ticks(&stream));
}

static void append_some(void)
{
    uint8_t count = (uint8_t)chance_between(1, 30);

    if (stream_space(&stream) <= 60u) {
        return;
    }
    if (chance_between(0, 2) != 0) {
        put_batch(count);
    } else {
        put_periods(count);
    }
}

// Passed is what was appended, wherever the interrupt is.
static void random_streams(void)
{
    uint32_t ticks = START_TICKS;

    for (uint16_t i = 0; i < ROUNDS; i++) {
        append_some();
        uint8_t tail =
            (uint8_t)(stream.retired + chance_between(0, stream_used(&stream)));
        while (stream.retired != tail) {
            uint8_t first = stream.retired;
            uint8_t count = pass(tail);
            ticks += appended_ticks(first, count);
            if (stream_waypoint_within(&stream, 0)) {
                TEST_ASSERT_EQUAL_UINT32(waypoint_ticks(stream_waypoint(&stream)),
                                         ticks & 0xFFFFFFuL);
                stream_pass_waypoint(&stream);
            }
        }
    }
    ticks += appended_ticks(stream.retired, stream_used(&stream));
    TEST_ASSERT_EQUAL_UINT32(stream.end_ticks, ticks);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(new_stream_is_empty);
    RUN_TEST(reset_forgets_everything);
    RUN_TEST(end_is_the_sum_of_all_entries);
    RUN_TEST(reserved_slots_hide_what_follows);
    RUN_TEST(marks_wait_for_a_period);
    RUN_TEST(marks_are_read_behind_their_period);
    RUN_TEST(marks_fill_up);
    RUN_TEST(periods_end_at_marks_and_other_entries);
    RUN_TEST(train_entries_name_their_train);
    RUN_TEST(the_rest_of_a_piece_is_a_train_like_others);
    RUN_TEST(entries_of_a_train_are_passed_together);
    RUN_TEST(the_older_train_is_known_by_its_entries);
    RUN_TEST(many_periods_end_at_a_place);
    RUN_TEST(places_leave_room_for_edges);
    RUN_TEST(single_periods_lead_from_edge_to_edge);
    RUN_TEST(other_entries_are_no_plain_way);
    RUN_TEST(on_the_plain_way);
    RUN_TEST(the_plain_way_ends_where_the_reader_lags);
    RUN_TEST(a_delay_moves_no_waypoint);
    RUN_TEST(length_of_the_newest_train);
    RUN_TEST(length_of_the_newest_period);
    RUN_TEST(random_streams);
    return UNITY_END();
}
