// SPDX-License-Identifier: MIT
// even_pixels_write() and train_pixel_singles(), which are assembly on a board, beside the C that
// they stand for: on lines and streams of random content, one of each at random addresses. All of
// both is equal behind each call, but for what is kept of the last quotient, which only saves
// divisions. And the entries of the ring are as long together as the stream says.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "clock/lock_grid.h"
#include "fakes/chance.h"
#include "fakes/promise.h"
#include "line/line.h"
#include "line/segment_pack.h"
#include "steps/even_pixel.h"
#include "stream/stream.h"
#include "unity.h"

#include "twins/even_pixel_twin.inc" // twin_even_pixels_write, twin_train_pixel_singles

#define QUEUE_BYTES 512u
#define CHOSEN      64u // of these; the others are the same again
#define SCENES      500u
#define CALLS       4u // in each of them
#define SHIFT_STEP  (sizeof(void *) > 2u ? 16u : 1u)
#define SHIFT_MOST  256u

struct parts {
    struct stream stream;
    struct line line;
    struct even even;
    struct segment_queue queue;
    struct pixel_period period;
    uint8_t bytes[QUEUE_BYTES];
};

// The part under test and its twin, each with a ring.
static struct step_ring rings[2];
static uint8_t places[2][sizeof(struct parts) + SHIFT_MOST] __attribute__((aligned(16)));
static struct parts *parts[2];
static uint16_t written, waited, refused;

void setUp(void)
{
    promise_broken = 0;
    chance_seed(0x7E57EA15uL);
    written = waited = refused = 0;
}

void tearDown(void)
{
    TEST_ASSERT_EQUAL_UINT16(0, promise_broken);
}

static uint8_t small(uint8_t most)
{
    return (uint8_t)chance_between(0, most);
}

static bool once_in(uint8_t times)
{
    return small((uint8_t)(times - 1u)) == 0;
}

static void link_parts(uint8_t which)
{
    struct parts *p = parts[which];

    p->stream.ring = &rings[which];
    p->line.source.queue = &p->queue;
    p->queue.out.bytes = p->bytes;
    if (p->line.edges.mode == LINE_GRID_EXACT) {
        p->line.edges.exact.period = &p->period;
    }
}

static void unlink_parts(uint8_t which)
{
    struct parts *p = parts[which];

    p->stream.ring = NULL;
    p->line.source.queue = NULL;
    p->queue.out.bytes = NULL;
    if (p->line.edges.mode == LINE_GRID_EXACT) {
        p->line.edges.exact.period = NULL;
    }
}

// Entries of the forms that pixels of few steps have, and others.
static void fill_queue(struct segment_queue *queue, uint8_t *bytes)
{
    queue->out.mask = QUEUE_BYTES - 1u;
    queue->out.at = (uint16_t)chance();
    queue->out.last = (int16_t)chance_between(0, 160);
    if (once_in(3)) {
        queue->out.last = (int16_t)-queue->out.last;
    }
    queue->head = (uint16_t)(queue->out.at + small(20));
    if (once_in(6)) { // the same low byte
        queue->head = (uint16_t)(queue->out.at + 256u);
    }
    queue->last = (int16_t)chance();
    for (uint8_t i = 0; i < CHOSEN; i++) {
        switch (small(7)) {
        case 0:
            bytes[i] = (uint8_t)chance();
            break;
        case 1:
        case 2:
            bytes[i] = (uint8_t)(SEGMENT_SHORT_RUN + 1u + small(8));
            break;
        case 3:
            bytes[i] = (uint8_t)(SEGMENT_NEAR_LAST - small(3));
            break;
        default:
            bytes[i] = (uint8_t)(SEGMENT_NEAR_ZERO - 8u + small(16));
            break;
        }
    }
    for (uint16_t i = CHOSEN; i < QUEUE_BYTES; i += CHOSEN) {
        memcpy(&bytes[i], bytes, CHOSEN);
    }
}

static uint32_t some_length(void)
{
    static const uint32_t edges[] = {0x10000uL, 0x3FFFFuL, 0x20000uL, 0x40000uL, 1024u};

    switch (small(5)) {
    case 0:
        return edges[small(4)] - 2u + small(4);
    case 1:
        return chance_between(0x10000uL, 0x50000uL);
    case 2: // around the shortest intervals
        return EVEN_PIXEL_MIN_TICKS * (8u + small(112)) - 2u + small(4);
    default:
        return chance_between(1024, 0xFFFFu);
    }
}

// The pixels of a line differ by less than 2^16 ticks.
static uint32_t about(uint32_t ticks)
{
    return ticks - 400u + chance_between(0, 800);
}

static void choose_grid(struct parts *p)
{
    struct line *line = &p->line;
    bool is_short = once_in(2);

    p->period.whole_ticks = some_length();
    p->period.divisor =
        is_short ? chance_between(1, 0xFFFFu) : chance_between(1, 0xFFFFFFFFuL);
    p->period.remainder = once_in(3) ? 0 : chance_between(0, p->period.divisor - 1u);
    line->edges.mode = once_in(5) ? LINE_GRID_WAITS : LINE_GRID_EXACT;
    line->edges.exact.sum = chance_between(0, p->period.divisor - 1u);
    line->edges.edge = small(6);
    if (line->edges.mode == LINE_GRID_WAITS) {
        line->edges.reached = (struct fine_ticks){.ticks = chance()};
        lock_grid_now()->waiting =
            (struct fine_ticks){.ticks = about(p->period.whole_ticks)};
    }
    line->source.edge_open = !once_in(4);
    line->to_edge_ticks = 0;
    if (!line->source.edge_open) {
        line->to_edge_ticks = about(p->period.whole_ticks);
    } else if (once_in(8)) { // a part of the pixel is there
        line->to_edge_ticks = chance_between(1, 400);
    }
}

static void choose_line(struct line *line)
{
    line->source.smooth = once_in(3);
    line->source.negative = once_in(2);
    line->source.segment.count = (int16_t)chance_between(0, 130);
    line->source.segment.repeat = (uint16_t)small(3);
    if (once_in(4)) {
        line->source.segment.repeat = (uint16_t)chance_between(253, 260);
    }
    line->speed = (uint16_t)(once_in(2) ? line->source.segment.count : small(130));
    line->curve_half = (int16_t)chance();
    line->position = (int16_t)chance();
    line->room = small(130);
}

static void choose_stream(struct stream *stream)
{
    memset(stream->waypoints, 0x5A, sizeof stream->waypoints);
    stream->head = (uint8_t)chance();
    stream->retired =
        (uint8_t)(stream->head - (once_in(2) ? chance_between(100, 252) : small(100)));
    stream->waypoint_head = (uint8_t)chance();
    stream->waypoint_placed = (uint8_t)(stream->waypoint_head - 1u);
    stream->waypoint_tail = (uint8_t)(stream->waypoint_head - chance_between(1, 15));
    stream->plain = once_in(3) ? 0 : WAYPOINT_PLAIN;
    // The waypoint that waits; a line's start is reached entry by entry.
    stream->waypoints[stream->waypoint_placed & (STREAM_WAYPOINTS - 1u)] =
        (struct waypoint){
            .position = (uint16_t)chance(),
            .way = stream->plain == 0 && once_in(2) ? WAYPOINT_START : 0,
    };
    stream->end_ticks = chance();
}

static void choose_even(struct even *even)
{
    even->steps =
        (uint16_t)(once_in(2) ? chance_between(1, 300) : chance_between(1, 32767));
    even->base_ticks = once_in(2) ? chance_between(2, 0xFCFEu) : chance_between(250, 260);
    even->remainder = once_in(3) ? 0 : (uint16_t)chance_between(0, even->steps - 1u);
    even->sum = (uint16_t)chance_between(0, even->steps - 1u);
}

static void choose_scene(void)
{
    for (uint8_t i = 0; i < 2u; i++) {
        parts[i] = (struct parts *)(void *)&places[i][small(SHIFT_MOST - 1u) /
                                                      SHIFT_STEP * SHIFT_STEP];
        memset(places[i], 0, sizeof places[i]);
    }
    memset(&rings[0], (int)(uint8_t)chance(), sizeof rings[0]);
    rings[1] = rings[0];
    fill_queue(&parts[0]->queue, parts[0]->bytes);
    choose_line(&parts[0]->line);
    choose_grid(parts[0]);
    choose_stream(&parts[0]->stream);
    choose_even(&parts[0]->even);
    *parts[1] = *parts[0];
    link_parts(0);
    link_parts(1);
}

// The C asks for the speed of a pixel before it sees that the pixel has too many steps; whoever
// writes that pixel notes its speed.
static void forget_speed_noted_early(void)
{
    int16_t count = parts[0]->line.source.segment.count;
    uint16_t steps = (uint16_t)(count < 0 ? -count : count);

    if (!parts[0]->line.source.smooth && steps > EVEN_PIXEL_MAX_STEPS &&
        steps <= UINT8_MAX) {
        parts[1]->line.speed = parts[0]->line.speed;
        parts[1]->line.curve_half = parts[0]->line.curve_half;
    }
}

static void compare(void)
{
    struct even_rate kept[2];

    forget_speed_noted_early();

    for (uint8_t i = 0; i < 2u; i++) {
        unlink_parts(i);
        kept[i] = parts[i]->line.even;
        parts[i]->line.even = (struct even_rate){.steps = 0};
    }
    TEST_ASSERT_EQUAL_MEMORY(&parts[1]->stream, &parts[0]->stream, sizeof(struct stream));
    TEST_ASSERT_EQUAL_MEMORY(parts[1], parts[0], sizeof(struct parts));
    TEST_ASSERT_EQUAL_MEMORY(&rings[1], &rings[0], sizeof(struct step_ring));
    for (uint8_t i = 0; i < 2u; i++) {
        parts[i]->line.even = kept[i];
        link_parts(i);
    }
}

static uint32_t ring_ticks(uint8_t from, uint8_t to)
{
    uint32_t sum = 0;

    for (; from != to; from++) {
        sum += ((uint32_t)rings[0].high[from] << 8 | rings[0].low[from]) + 1u;
    }
    return sum;
}

// The reader goes on, and the writer is at a step.
static void read_some(void)
{
    uint8_t passed = small(120);
    uint8_t waypoints = small(3);

    for (uint8_t i = 0; i < 2u; i++) {
        struct stream *stream = &parts[i]->stream;
        stream->retired =
            (uint8_t)(stream->retired + (passed < stream_used(stream) ? passed : 0u));
        uint8_t most = (uint8_t)(stream->waypoint_placed - stream->waypoint_tail);
        stream->waypoint_tail =
            (uint8_t)(stream->waypoint_tail + (waypoints < most ? waypoints : 0u));
    }
}

static void write_pixels(void)
{
    bool negative = once_in(3);
    uint8_t budget =
        once_in(2) ? (uint8_t)chance_between(1, 20) : (uint8_t)chance_between(1, 255);
    uint8_t from = parts[0]->stream.head;
    uint32_t before = parts[0]->stream.end_ticks;

    uint8_t made =
        even_pixels_write(&parts[0]->line, &parts[0]->stream, negative, budget);
    uint8_t wanted =
        twin_even_pixels_write(&parts[1]->line, &parts[1]->stream, negative, budget);
    TEST_ASSERT_EQUAL_UINT8(wanted, made);
    compare();
    TEST_ASSERT_EQUAL_UINT32(parts[0]->stream.end_ticks - before,
                             ring_ticks(from, parts[0]->stream.head));
    written = (uint16_t)(written + (made != 0 && made != EVEN_PIXEL_WAITS));
    waited = (uint16_t)(waited + (made == EVEN_PIXEL_WAITS));
    refused = (uint16_t)(refused + (made == 0));
}

static void pixels_of_few_steps(void)
{
    *lock_grid_now() = (struct lock_grid){.lead_edges = 8, .divider = 1};
    for (uint16_t i = 0; i < SCENES; i++) {
        choose_scene();
        for (uint8_t k = 0; k < CALLS; k++) {
            write_pixels();
            read_some();
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT16(SCENES / 2u, written);
    TEST_ASSERT_GREATER_THAN_UINT16(SCENES / 10u, waited);
    TEST_ASSERT_GREATER_THAN_UINT16(SCENES / 10u, refused);
}

static void single_periods(void)
{
    for (uint16_t i = 0; i < SCENES; i++) {
        choose_scene();
        uint8_t count = (uint8_t)chance_between(1, 60);
        uint8_t from = parts[0]->stream.head;
        uint32_t made = train_pixel_singles(&parts[0]->even, &parts[0]->stream, count);
        uint32_t wanted =
            twin_train_pixel_singles(&parts[1]->even, &parts[1]->stream, count);
        TEST_ASSERT_EQUAL_UINT32(wanted, made);
        compare();
        TEST_ASSERT_EQUAL_UINT32(made, ring_ticks(from, parts[0]->stream.head));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(pixels_of_few_steps);
    RUN_TEST(single_periods);
    return UNITY_END();
}
