// SPDX-License-Identifier: MIT
// The grid of locked lines: by hand, and in random orders of events against a model that keeps the
// time of every pixel edge and counts in 32 bits.
#include "clock/lock_grid.h"

#include <stddef.h>

#include "base/fine.h"
#include "fakes/chance.h"
#include "unity.h"

#define PERIOD_TICKS    20000uL // of the clock's edges
#define TOLERANCE_TICKS 200u
#define SLACK_TICKS                                                                      \
    (TOLERANCE_TICKS + TOLERANCE_TICKS / 64u + 1u) // for each edge of a pixel
#define LEAD_EDGES 4u
#define HOLD_OVER  4u
#define LINES      3u

static struct lock_grid *grid;
static struct line_grid line;
static uint32_t clock_ticks; // the clock's newest edge

static void clock_edge(uint32_t period_ticks)
{
    clock_ticks += period_ticks;
    TEST_ASSERT_EQUAL(true, clock_filter_edge(&grid->filter, clock_ticks));
}

static void clock_edges(uint16_t count, uint32_t period_ticks)
{
    for (; count != 0; count--) {
        clock_edge(period_ticks);
    }
}

// A grid whose clock has settled at PERIOD_TICKS. Its edges have these numbers from now on.
static void open_grid(uint16_t divider, uint16_t newest_edge)
{
    *grid =
        (struct lock_grid){.locks = true, .divider = divider, .lead_edges = LEAD_EDGES};
    grid->pixel =
        (struct pixel_period){.whole_ticks = PERIOD_TICKS * divider, .divisor = 1};
    lock_grid_tolerate(TOLERANCE_TICKS);
    grid->filter.hold_over = HOLD_OVER;
    clock_filter_aim(&grid->filter, PERIOD_TICKS, (uint16_t)(divider + LEAD_EDGES));
    while (!clock_filter_settled(&grid->filter)) {
        clock_edge(PERIOD_TICKS);
    }
    grid->filter.edge = newest_edge;
}

void setUp(void)
{
    chance_seed(1);
    grid = lock_grid_now();
    clock_ticks = 0xFFF00000uL; // times wrap soon
    open_grid(1, 0);
}

void tearDown(void)
{
}

static void an_exact_line_has_the_period_of_the_settings(void)
{
    static const uint8_t more[] = {0, 0, 1, 0, 0, 1};
    static const struct pixel_period thirds = {533333uL, 1, 3};

    grid->lead_edges = 0;
    line_grid_start_exact(&line, &thirds);
    for (size_t i = 0; i < sizeof more; i++) {
        TEST_ASSERT_EQUAL_UINT32(533333uL + more[i], line_grid_advance(&line));
        TEST_ASSERT_EQUAL(false, line_grid_early(&line, false));
    }
    TEST_ASSERT_FALSE(line_grid_locked(&line));
}

// Pixels of a line that waits, where the clock's period has a fraction.
static void check_waiting(uint16_t divider)
{
    const uint64_t fine = 20000uLL << 16 | 0x5678u;
    uint32_t sum = 0;

    open_grid(divider, 0);
    grid->filter.period = (struct fine_ticks){.fraction = 0x5678, .ticks = 20000};
    lock_grid_hold_period();
    grid->filter.period.ticks =
        1; // what the clock does now changes no pixel of such a line
    line_grid_start_locked(&line);
    for (uint8_t pixel = 1; pixel <= 9; pixel++) {
        sum += line_grid_advance(&line);
        TEST_ASSERT_EQUAL_UINT32((uint32_t)(fine * divider * pixel >> 16), sum);
    }
}

static void a_waiting_line_has_the_period_held(void)
{
    static const uint16_t dividers[] = {1, 2, 3, 10, 511, 512, 999, 1000};

    for (size_t i = 0; i < sizeof dividers / sizeof dividers[0]; i++) {
        check_waiting(dividers[i]);
    }
}

// Line zero comes with the next edge or later, so that the pixel edge reached is a clock edge more
// ahead than its own number of edges.
// Several axes are decoded four times as long ahead before line zero.
#define WAITING_EDGES (SEVERAL_AXES ? 4u * (LEAD_EDGES - 1u) + 1u : LEAD_EDGES)

static void a_waiting_line_goes_on_as_far_as_the_lead(void)
{
    open_grid(2, 0);
    lock_grid_hold_period();
    line_grid_start_locked(&line);
    for (unsigned edges = 1; edges <= WAITING_EDGES; edges += 2u) {
        TEST_ASSERT_EQUAL(false, line_grid_early(&line, false));
        (void)line_grid_advance(&line);
    }
    TEST_ASSERT_EQUAL(true, line_grid_early(&line, false));
    TEST_ASSERT_EQUAL(false, line_grid_early(&line, true)); // it runs a pixel ahead
    (void)line_grid_advance(&line);
    TEST_ASSERT_EQUAL(true, line_grid_early(&line, true));
}

static void pixel_edges_are_every_so_many_edges_of_the_clock(void)
{
    open_grid(7, 0xFFFD);
    uint32_t zero = clock_ticks + 5u * PERIOD_TICKS;

    TEST_ASSERT_EQUAL_UINT32(zero, lock_grid_begin(5));
    for (uint16_t number = 1; number < 4u * LOCK_GRID_EDGES; number++) {
        TEST_ASSERT_EQUAL_UINT32(zero + number * 7u * PERIOD_TICKS, lock_grid_next());
        TEST_ASSERT_EQUAL_UINT16(number, grid->newest);
    }
}

// A line that waited for line zero, two pixels of it, meets the grid with its third one. The clock
// has become slower meanwhile.
static void a_line_that_is_placed_comes_onto_the_grid(void)
{
    lock_grid_hold_period();
    line_grid_start_locked(&line);
    (void)line_grid_advance(&line);
    (void)line_grid_advance(&line);
    clock_edges(400, PERIOD_TICKS + 30u);
    uint32_t zero = lock_grid_begin(1);

    line_grid_place(&line, grid->newest, zero);
    TEST_ASSERT_EQUAL_UINT16(2, line.edge);
    TEST_ASSERT_UINT32_WITHIN(1, PERIOD_TICKS + 3u * 30u, line_grid_advance(&line));
    TEST_ASSERT_UINT32_WITHIN(1, PERIOD_TICKS + 30u, line_grid_advance(&line));
    TEST_ASSERT_EQUAL_UINT32(lock_grid_now()->times[line.edge % LOCK_GRID_EDGES],
                             line.reached.ticks);
}

static void a_line_beside_others_begins_at_a_later_number(void)
{
    (void)lock_grid_begin(1);
    (void)lock_grid_next();
    lock_grid_hold_period();
    line_grid_start_locked(&line);
    (void)line_grid_advance(&line);
    uint32_t zero = lock_grid_next();

    line_grid_place(&line, grid->newest, zero);
    TEST_ASSERT_EQUAL_UINT16(3, line.edge);
    TEST_ASSERT_EQUAL_UINT32(zero + PERIOD_TICKS, line.reached.ticks);
}

#if SEVERAL_AXES
// One of two lines that begin together was decoded ahead, with the period held. The clock has
// become faster since. Both end their pixels together all the same, and come onto the grid.
static void lines_that_begin_together_keep_what_one_has_decoded(void)
{
    struct line_grid fast;

    lock_grid_hold_period();
    line_grid_start_locked(&line);
    line_grid_start_locked(&fast);
    (void)line_grid_advance(&fast);
    (void)line_grid_advance(&fast);
    (void)line_grid_advance(&fast);
    clock_edges(400, PERIOD_TICKS - 30u);
    uint32_t zero = lock_grid_begin(1);

    line_grid_place(&line, grid->newest, zero);
    line_grid_place(&fast, grid->newest, zero);
    TEST_ASSERT_EQUAL_UINT16(0, line_grid_decoded(&line, grid->newest));
    TEST_ASSERT_EQUAL_UINT16(3, line_grid_decoded(&fast, grid->newest));
    lock_grid_keep(3, zero);
    for (uint8_t pixel = 1; pixel <= 3; pixel++) {
        TEST_ASSERT_EQUAL_UINT32(PERIOD_TICKS, line_grid_advance(&line));
    }
    TEST_ASSERT_EQUAL_UINT32(fast.reached.ticks, line.reached.ticks);
    for (uint8_t pixel = 4; pixel <= 8; pixel++) {
        (void)line_grid_advance(&line);
        (void)line_grid_advance(&fast);
        TEST_ASSERT_EQUAL_UINT32(fast.reached.ticks, line.reached.ticks);
    }
    TEST_ASSERT_UINT32_WITHIN(8, zero + 8u * (PERIOD_TICKS - 30u), line.reached.ticks);
}

// A line zero that is not the grid's first edge: beside lines that run.
static void a_later_line_has_decoded_from_its_own_line_zero(void)
{
    lock_grid_hold_period();
    line_grid_start_locked(&line);
    for (uint8_t pixel = 1; pixel <= 3; pixel++) {
        (void)line_grid_advance(&line);
    }
    clock_edges(400, PERIOD_TICKS);
    (void)lock_grid_begin(1);
    (void)lock_grid_next();
    uint32_t zero = lock_grid_next();

    line_grid_place(&line, grid->newest, zero);
    TEST_ASSERT_EQUAL_UINT16(2, grid->newest);
    TEST_ASSERT_EQUAL_UINT16(3, line_grid_decoded(&line, grid->newest));
}

static void a_line_that_is_not_placed_has_decoded_nothing_of_the_grid(void)
{
    lock_grid_hold_period();
    line_grid_start_locked(&line);
    (void)line_grid_advance(&line);
    TEST_ASSERT_EQUAL_UINT16(0, line_grid_decoded(&line, 0));
}
#endif

static void pixels(uint16_t count, uint32_t period_ticks, uint32_t ticks)
{
    for (; count != 0; count--) {
        clock_edges(3, period_ticks);
        TEST_ASSERT_EQUAL_UINT32(ticks, line_grid_advance(&line));
    }
}

// A clock that leaves its tolerance is followed as fast as the limits of a pixel allow, and when it
// has come back the line makes up for what it owes.
static void check_limits(int32_t off_ticks, int32_t limit_ticks)
{
    const uint32_t whole = 3u * PERIOD_TICKS;

    open_grid(3, 0);
    clock_edges(300, PERIOD_TICKS + (uint32_t)off_ticks);
    uint32_t zero = lock_grid_begin(1);
    line_grid_start_locked(&line);
    line_grid_place(&line, 0, zero);
    // In the end the line is more than a pixel off the grid.
    pixels(500, PERIOD_TICKS + (uint32_t)off_ticks, whole + (uint32_t)limit_ticks);
    pixels(2, PERIOD_TICKS, whole + (uint32_t)limit_ticks);
    for (uint8_t i = 0; i < 200; i++) {
        clock_edges(3, PERIOD_TICKS);
        TEST_ASSERT_UINT32_WITHIN(3u * SLACK_TICKS, whole, line_grid_advance(&line));
    }
    TEST_ASSERT_EQUAL_UINT32(grid->times[line.edge % LOCK_GRID_EDGES],
                             line.reached.ticks);
    TEST_ASSERT_UINT32_WITHIN(1, clock_ticks + PERIOD_TICKS, line.reached.ticks);
    pixels(10, PERIOD_TICKS, whole);
}

static void no_pixel_is_shorter_or_longer_than_its_limits(void)
{
    check_limits(-250, -(int32_t)(3u * SLACK_TICKS));
    check_limits(250, (int32_t)(3u * SLACK_TICKS));
}

static void check_tolerates(bool tolerates, int32_t off_ticks)
{
    grid->filter.period.ticks = PERIOD_TICKS + (uint32_t)off_ticks;
    TEST_ASSERT_EQUAL(tolerates, lock_grid_tolerates());
}

static void the_tolerance_is_two_sided_and_belongs_to_a_settled_clock(void)
{
    check_tolerates(true, 0);
    check_tolerates(true, -(int32_t)TOLERANCE_TICKS);
    check_tolerates(true, TOLERANCE_TICKS);
    check_tolerates(false, -(int32_t)TOLERANCE_TICKS - 1);
    check_tolerates(false, TOLERANCE_TICKS + 1);
    clock_filter_restart(&grid->filter);
    check_tolerates(true, TOLERANCE_TICKS + 1);
}

static void check_passes(bool passes, uint16_t number)
{
    uint16_t found = 0xFFFF;

    TEST_ASSERT_EQUAL(passes, lock_grid_passes(&found));
    TEST_ASSERT_EQUAL_UINT16(number, found);
}

static void every_pixel_edge_is_known_when_it_comes(void)
{
    open_grid(3, 0xFFFB);
    (void)lock_grid_begin(2);
    clock_edge(PERIOD_TICKS);
    check_passes(false, 0);
    clock_edge(PERIOD_TICKS);
    check_passes(true, 0);
    for (uint16_t number = 1; number < 6; number++) {
        clock_edge(PERIOD_TICKS);
        check_passes(false, number);
        clock_edge(PERIOD_TICKS);
        check_passes(false, number);
        clock_edge(PERIOD_TICKS);
        check_passes(true, number);
    }
}

static void pixel_edges_are_numbered_anew(void)
{
    (void)lock_grid_begin(1);
    clock_edges(3, PERIOD_TICKS);
    check_passes(true, 2);
    TEST_ASSERT_EQUAL_UINT32(clock_ticks + 2u * PERIOD_TICKS, lock_grid_begin(2));
    TEST_ASSERT_EQUAL_UINT16(0, grid->newest);
    clock_edge(PERIOD_TICKS);
    check_passes(false, 0);
    clock_edge(PERIOD_TICKS);
    check_passes(true, 0);
}

static void a_pixel_edge_that_is_missing_is_passed_over(void)
{
    open_grid(3, 0);
    (void)lock_grid_begin(2);
    clock_edges(4, PERIOD_TICKS);
    clock_edge(2u * PERIOD_TICKS);
    check_passes(false, 2);
    clock_edges(2, PERIOD_TICKS);
    check_passes(true, 2);
}

// Edges of the clock that came before do not count for a line that follows from here on.
static void edges_are_counted_from_where_a_line_follows(void)
{
    uint16_t before = 0;
    uint16_t number = 0;

    open_grid(3, 0);
    (void)lock_grid_begin(2);
    clock_edges(4, PERIOD_TICKS);
    (void)lock_grid_passes(&before);
    clock_edges(2, PERIOD_TICKS);
    lock_grid_follow_from_here();
    for (uint8_t edge = 1; edge <= 6u; edge++) {
        clock_edge(PERIOD_TICKS);
        TEST_ASSERT_EQUAL(edge % 3u == 0, lock_grid_passes(&number));
        TEST_ASSERT_EQUAL_UINT16(before + (edge + 2u) / 3u, number);
    }
}

// What the model knows: all numbers count from line zero, which is pixel edge FIRST_NUMBER.
#define FIRST_NUMBER 0xFFE0u
#define FIRST_EDGES  2u
#define KEPT         64u
static struct {
    uint32_t edges;       // of the clock, since the grid began
    uint32_t fixed;       // pixel edges that have their times
    uint32_t times[KEPT]; // of the newest ones
    struct {
        uint32_t edge;
        uint32_t reached;
    } lines[LINES];
} model;

// Clock edges from the newest one to a pixel edge.
static int32_t model_edges_to(uint32_t number)
{
    return (int32_t)(FIRST_EDGES + number * grid->divider) - (int32_t)model.edges;
}

static uint32_t model_time(uint32_t number)
{
    while (model.fixed <= number) {
        model.times[model.fixed % KEPT] =
            clock_filter_ahead(&grid->filter, (uint16_t)model_edges_to(model.fixed));
        model.fixed++;
    }
    return model.times[number % KEPT];
}

static uint32_t model_advance(uint8_t which)
{
    uint32_t ticks = model_time(++model.lines[which].edge) - model.lines[which].reached;
    uint32_t middle = PERIOD_TICKS * grid->divider;
    uint32_t slack = (uint32_t)SLACK_TICKS * grid->divider;

    if ((int32_t)ticks < (int32_t)(middle - slack)) {
        ticks = middle - slack;
    } else if (ticks > middle + slack) {
        ticks = middle + slack;
    }
    model.lines[which].reached += ticks;
    return ticks;
}

// Pixel edges that the last line is behind the newest one.
static uint32_t model_spread(void)
{
    uint32_t most = 0;

    for (uint8_t i = 0; i < LINES; i++) {
        uint32_t behind = model.fixed - model.lines[i].edge;
        most = behind > most ? behind : most;
    }
    return most;
}

static void open_model(struct line_grid *lines, uint16_t divider)
{
    open_grid(divider, 0xFFC0);
    lock_grid_hold_period();
    uint32_t zero = lock_grid_begin(FIRST_EDGES);

    grid->newest = FIRST_NUMBER;
    grid->due = FIRST_NUMBER;
    grid->times[FIRST_NUMBER % LOCK_GRID_EDGES] = zero;
    model.edges = 0;
    model.fixed = 1;
    model.times[0] = zero;
    for (uint8_t i = 0; i < LINES; i++) {
        line_grid_start_locked(&lines[i]);
        line_grid_place(&lines[i], FIRST_NUMBER, zero);
        model.lines[i].edge = 0;
        model.lines[i].reached = zero;
    }
}

static void advance_both(struct line_grid *lines, uint8_t which)
{
    bool ahead = (chance() & 1u) != 0;
    int32_t edges = model_edges_to(model.lines[which].edge) - (ahead ? grid->divider : 0);
    bool early = edges > (int32_t)LEAD_EDGES;

    TEST_ASSERT_EQUAL(early, line_grid_early(&lines[which], ahead));
    // The newest pixel edge pushes the oldest one out.
    if (early || model_edges_to(model.fixed) < 1 ||
        (model.lines[which].edge + 1u == model.fixed &&
         model_spread() >= LOCK_GRID_EDGES)) {
        return;
    }
    TEST_ASSERT_EQUAL_UINT32(model_advance(which), line_grid_advance(&lines[which]));
    TEST_ASSERT_EQUAL_UINT32(model.lines[which].reached, lines[which].reached.ticks);
}

static void edge_of_model(void)
{
    uint16_t number = 0;

    clock_edge(chance_between(PERIOD_TICKS - 150u, PERIOD_TICKS + 150u));
    model.edges++;
    uint32_t behind = (model.edges + grid->divider - 1u - FIRST_EDGES) / grid->divider;
    bool passes = model_edges_to(behind) == 0;

    if (model.edges < FIRST_EDGES) {
        return;
    }
    TEST_ASSERT_EQUAL(passes, lock_grid_passes(&number));
    TEST_ASSERT_EQUAL_UINT16(FIRST_NUMBER + behind, number);
}

// Lines that are decoded in any order have the same pixel edges, each fixed when the first of them
// needs it, whatever the clock does later.
static void lines_in_any_order(uint16_t divider)
{
    struct line_grid lines[LINES];

    open_model(lines, divider);
    for (uint16_t events = 0; events < 3000u; events++) {
        uint32_t what = chance_between(0, 2u * LINES + 1u);
        // The clock waits for lines that hang back.
        if (what < LINES + 1u || model_spread() >= LOCK_GRID_EDGES) {
            advance_both(lines, (uint8_t)chance_between(0, LINES - 1u));
        }
        if (what > LINES && model_edges_to(model.fixed) > 1) {
            edge_of_model();
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(300u / divider, model.fixed);
}

static void lines_share_the_grid(void)
{
    lines_in_any_order(1);
    lines_in_any_order(3);
    lines_in_any_order(32);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_exact_line_has_the_period_of_the_settings);
    RUN_TEST(a_waiting_line_has_the_period_held);
    RUN_TEST(a_waiting_line_goes_on_as_far_as_the_lead);
    RUN_TEST(pixel_edges_are_every_so_many_edges_of_the_clock);
    RUN_TEST(a_line_that_is_placed_comes_onto_the_grid);
    RUN_TEST(a_line_beside_others_begins_at_a_later_number);
#if SEVERAL_AXES
    RUN_TEST(lines_that_begin_together_keep_what_one_has_decoded);
    RUN_TEST(a_later_line_has_decoded_from_its_own_line_zero);
    RUN_TEST(a_line_that_is_not_placed_has_decoded_nothing_of_the_grid);
#endif
    RUN_TEST(no_pixel_is_shorter_or_longer_than_its_limits);
    RUN_TEST(the_tolerance_is_two_sided_and_belongs_to_a_settled_clock);
    RUN_TEST(every_pixel_edge_is_known_when_it_comes);
    RUN_TEST(pixel_edges_are_numbered_anew);
    RUN_TEST(a_pixel_edge_that_is_missing_is_passed_over);
    RUN_TEST(edges_are_counted_from_where_a_line_follows);
    RUN_TEST(lines_share_the_grid);
    return UNITY_END();
}
