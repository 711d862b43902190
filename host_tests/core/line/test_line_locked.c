// SPDX-License-Identifier: MIT
// Pieces of a line that is locked to the pixel clock: those of a free line where the clock is
// exact, and on the clock's own edges where it is not.
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fakes/chance.h"
#include "fakes/worked_example.h"
#include "line/line.h"
#include "unity.h"

#define SLOTS    64u
#define TIMER_HZ 16000000uL
// 40 Hz, a multiple of the worked example's line speed.
#define PIXEL_TICKS ((uint32_t)400000)
#define SPEED       1000u
#define LEAD_EDGES  3u
#define PIECES_MAX  40u

static uint8_t slots[4u * SLOTS];
static struct segment_queue queue;
static struct pixel_period period;
static struct lock_grid *grid;
static struct line line;
static struct piece piece;
static struct line_grid beside; // walks along the same pixel edges as the line
static uint32_t clock_ticks;    // newest edge
static uint16_t zero_edge;      // line zero, among the clock's edges
static uint32_t edge_ticks;     // period of the clock's edges
static uint32_t noise_ticks;    // each of them is off by so much, at most

static void clock_edge(void)
{
    uint32_t noise = noise_ticks == 0 ? 0 : chance_between(0, 2u * noise_ticks);

    clock_ticks += edge_ticks + noise - noise_ticks;
    TEST_ASSERT_EQUAL(true, clock_filter_edge(&grid->filter, clock_ticks));
}

// A clock of so many edges a pixel that has settled, and a line that waits for it.
static void open_line(uint16_t backlash, uint16_t divider)
{
    struct segment entry;

    segment_queue_init(&queue, slots, sizeof slots);
    for (uint8_t i = 0; worked_entry(backlash, i, &entry); i++) {
        TEST_ASSERT_EQUAL(true, segment_queue_push(&queue, entry));
    }
    (void)pixel_period_set(&period, TIMER_HZ, TIMER_HZ, PIXEL_TICKS);
    grid = lock_grid_now();
    *grid = (struct lock_grid){
        .locks = true, .divider = divider, .lead_edges = LEAD_EDGES, .pixel = period};
    edge_ticks = PIXEL_TICKS / divider;
    lock_grid_tolerate(edge_ticks / 50u);
    grid->filter.hold_over = 4;
    clock_filter_aim(&grid->filter, edge_ticks, (uint16_t)(divider + LEAD_EDGES));
    while (!clock_filter_settled(&grid->filter)) {
        clock_edge();
    }
    lock_grid_hold_period();
    line_begin(&line, &period, &queue);
    line_grid_start_locked(&line.edges);
    line_grid_start_locked(&beside);
}

void setUp(void)
{
    chance_seed(1);
    clock_ticks = 0xFFF00000uL; // times wrap soon
    noise_ticks = 0;
}

void tearDown(void)
{
}

// Line zero is the next edge but one of the clock.
static uint32_t place_line(void)
{
    uint32_t zero = lock_grid_begin(2);

    zero_edge = grid->newest_edge;
    line_grid_place(&line.edges, grid->newest, zero);
    line_grid_place(&beside, grid->newest, zero);
    return zero;
}

// The next piece, when the clock has come near enough; false at the line's end.
static bool take(void)
{
    while (line_is_early(&line)) {
        clock_edge();
    }
    return line_next(&line, &piece) == LINE_PIECE;
}

// The same, of a line that is placed: it has gone on as late as it may, when the pixel edge that it
// has reached came near enough, or with backlash the one before.
static bool take_late(void)
{
    bool waits = line_is_early(&line);

    if (waits || line.source.shifted) {
        while (line_is_early(&line)) {
            clock_edge();
        }
        int16_t edges = (int16_t)(uint16_t)(zero_edge + line.edges.edge * grid->divider -
                                            grid->filter.edge);
        int16_t most = (int16_t)(LEAD_EDGES + (line.source.shifted ? grid->divider : 0));
        TEST_ASSERT_LESS_OR_EQUAL_INT16(most, edges);
        if (waits) {
            TEST_ASSERT_EQUAL_INT16(most, edges);
        }
    }
    return take();
}

static void keep_pieces(struct piece *pieces, uint8_t *count)
{
    for (*count = 0; take(); (*count)++) {
        TEST_ASSERT_LESS_THAN_UINT8(PIECES_MAX, *count);
        pieces[*count] = piece;
    }
}

static void check_same(const struct piece *free_piece, const struct piece *locked)
{
    TEST_ASSERT_EQUAL_UINT32(free_piece->ticks, locked->ticks);
    TEST_ASSERT_EQUAL_UINT16(free_piece->steps, locked->steps);
    TEST_ASSERT_EQUAL_UINT16(free_piece->start_speed, locked->start_speed);
    TEST_ASSERT_EQUAL(free_piece->curved, locked->curved);
    TEST_ASSERT_EQUAL(free_piece->negative, locked->negative);
    TEST_ASSERT_EQUAL(free_piece->has_edge, locked->has_edge);
    TEST_ASSERT_EQUAL_UINT16(free_piece->edge_steps, locked->edge_steps);
    TEST_ASSERT_EQUAL_UINT32(free_piece->edge_ticks, locked->edge_ticks);
    TEST_ASSERT_EQUAL_INT16(free_piece->edge_position, locked->edge_position);
}

static void compare_with_free(uint16_t backlash, uint16_t divider)
{
    static struct piece pieces[PIECES_MAX];
    uint8_t count = 0;

    open_line(backlash, divider);
    line_grid_start_exact(&line.edges, &period);
    keep_pieces(pieces, &count);
    TEST_ASSERT_GREATER_THAN_UINT8(30, count);
    open_line(backlash, divider);
    for (uint8_t i = 0; i < count; i++) {
        // Two pieces are made while the line waits.
        if (i == 2) {
            (void)place_line();
        }
        TEST_ASSERT_EQUAL(true, take());
        check_same(&pieces[i], &piece);
    }
    TEST_ASSERT_EQUAL(false, take());
}

static void an_exact_clock_makes_the_pieces_of_a_free_line(void)
{
    static const uint16_t backlashes[] = {0, 1, 250, 500, 999, SPEED};

    for (size_t i = 0; i < sizeof backlashes / sizeof backlashes[0]; i++) {
        compare_with_free(backlashes[i], 1);
        compare_with_free(backlashes[i], 2);
    }
}

// The part of a pixel by which a line with this backlash runs ahead of the pixel's end.
static uint32_t ahead(uint16_t backlash, uint32_t ticks)
{
    return (uint32_t)((uint64_t)ticks * backlash / SPEED);
}

// The pixels of the ramp end ahead of their edges, the take-up and everything behind it on them.
static void check_on_the_edges(uint16_t backlash, uint16_t divider)
{
    open_line(backlash, divider);
    uint32_t zero = place_line();
    uint32_t at = zero;
    uint32_t edge = zero;

    for (uint8_t i = 0; take_late(); i++) {
        bool shifted = i <= WORKED_RAMP_PX;
        bool takes_up = i == WORKED_RAMP_PX + 1u;
        at += piece.ticks;
        if (!takes_up) {
            uint32_t ticks = line_grid_advance(&beside);
            edge += ticks;
            TEST_ASSERT_EQUAL_UINT32(shifted ? edge - ahead(backlash, ticks) : edge, at);
        } else {
            TEST_ASSERT_EQUAL_UINT16(backlash, piece.steps);
            TEST_ASSERT_EQUAL_UINT32(edge, at);
        }
        TEST_ASSERT_EQUAL(i != 0, piece.has_edge);
        if (i != 0) {
            TEST_ASSERT_EQUAL_UINT32(shifted ? ahead(backlash, piece.ticks) : piece.ticks,
                                     piece.edge_ticks);
        }
    }
    TEST_ASSERT_EQUAL_INT32(10836L + backlash, line.position);
}

static void pieces_follow_a_clock_that_is_off_and_noisy(void)
{
    noise_ticks = 300;
    for (uint16_t backlash = 1; backlash < SPEED; backlash = (uint16_t)(backlash + 83u)) {
        check_on_the_edges(backlash, 1);
        check_on_the_edges(backlash, 4);
    }
}

// The pixels that are written as a whole wait for the clock, too.
static void a_whole_pixel_has_no_length_before_its_clock_edges(void)
{
    open_line(0, 1);
    (void)place_line();
    (void)line_next(&line, &piece);
    while (!line_is_early(&line)) {
        TEST_ASSERT_UINT32_WITHIN(1, PIXEL_TICKS, line_pixel_ticks(&line));
        line_pass_even(&line, 4);
        (void)line_grid_advance(&beside);
    }
    TEST_ASSERT_EQUAL_UINT16(beside.edge + 1u, line.edges.edge);
    TEST_ASSERT_EQUAL_UINT32(0, line_pixel_ticks(&line));
    TEST_ASSERT_EQUAL_UINT16(beside.edge + 1u, line.edges.edge);
    clock_edge();
    TEST_ASSERT_EQUAL_UINT32(PIXEL_TICKS, line_pixel_ticks(&line));
    // The pixel has its length now, and keeps it.
    TEST_ASSERT_FALSE(line_is_early(&line));
    TEST_ASSERT_EQUAL_UINT32(PIXEL_TICKS, line_pixel_ticks(&line));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_exact_clock_makes_the_pieces_of_a_free_line);
    RUN_TEST(pieces_follow_a_clock_that_is_off_and_noisy);
    RUN_TEST(a_whole_pixel_has_no_length_before_its_clock_edges);
    return UNITY_END();
}
