// SPDX-License-Identifier: MIT
// The two promises of a walk: the last step falls on the end of the piece, and every step is on the
// right side of the pixel edge. No other step may move.
#include <stdint.h>

#include "steps/walk.h"
#include "unity.h"

#define STEPS_MAX 40u

static struct piece piece;
static uint32_t plain_ticks[STEPS_MAX + 1u];  // places without an edge, from 1
static uint32_t walked_ticks[STEPS_MAX + 1u]; // with one
static uint16_t flagged;                      // step that came with at_edge, 0: none

void setUp(void)
{
    piece = (struct piece){.ticks = 1000, .steps = 7};
}

void tearDown(void)
{
}

static void walk_through(uint32_t *places)
{
    struct walk walk = {0};
    uint32_t at = 0;

    flagged = 0;
    walk_start(&walk, &piece);
    for (uint16_t k = 1; k <= piece.steps; k++) {
        TEST_ASSERT_FALSE(walk_done(&walk));
        at += walk_next(&walk);
        places[k] = at;
        if (walk.at_edge) {
            TEST_ASSERT_EQUAL_UINT16(0, flagged);
            flagged = k;
        }
    }
    TEST_ASSERT_TRUE(walk_done(&walk));
}

static uint32_t wanted_place(uint16_t k)
{
    if (k == piece.steps) {
        return piece.ticks;
    }
    if (k <= piece.edge_steps) {
        return plain_ticks[k] > piece.edge_ticks ? piece.edge_ticks : plain_ticks[k];
    }
    return plain_ticks[k] <= piece.edge_ticks ? piece.edge_ticks + 1u : plain_ticks[k];
}

static void check_edge(uint16_t edge_steps, uint32_t edge_ticks)
{
    piece.has_edge = true;
    piece.edge_steps = edge_steps;
    piece.edge_ticks = edge_ticks;
    walk_through(walked_ticks);
    for (uint16_t k = 1; k <= piece.steps; k++) {
        TEST_ASSERT_EQUAL_UINT32(wanted_place(k), walked_ticks[k]);
    }
    TEST_ASSERT_EQUAL_UINT16(edge_steps, flagged);
}

// After each number of steps, with the edge where it rounds to and one tick to either
// side.
static void check_edges_everywhere(void)
{
    piece.has_edge = false;
    walk_through(plain_ticks);
    plain_ticks[0] = 0;
    for (uint16_t k = 0; k < piece.steps; k++) {
        if (k != 0) {
            check_edge(k, plain_ticks[k] - 1u);
            check_edge(k, plain_ticks[k]);
        }
        check_edge(k, plain_ticks[k + 1u] - 1u);
        if (k + 1u < piece.steps) {
            check_edge(k, plain_ticks[k + 1u]);
        }
    }
    check_edge(piece.steps, piece.ticks);
}

static void last_step_at_the_end(void)
{
    walk_through(plain_ticks);
    TEST_ASSERT_EQUAL_UINT32(143, plain_ticks[1]);
    TEST_ASSERT_EQUAL_UINT32(1000, plain_ticks[7]);
    TEST_ASSERT_EQUAL_UINT16(0, flagged);
}

static void one_step(void)
{
    piece.steps = 1;
    walk_through(plain_ticks);
    TEST_ASSERT_EQUAL_UINT32(1000, plain_ticks[1]);
    check_edge(0, 400);
    check_edge(1, 1000);
}

static void even_edges(void)
{
    check_edges_everywhere();
}

static void many_even_edges(void)
{
    piece.ticks = 533333uL;
    piece.steps = STEPS_MAX;
    check_edges_everywhere();
}

static void two_steps(void)
{
    piece.steps = 2;
    check_edges_everywhere();
}

static void curved_edges(void)
{
    piece =
        (struct piece){.ticks = 533333uL, .steps = 12, .start_speed = 8, .curved = true};
    check_edges_everywhere();
}

static void curved_edges_from_rest(void)
{
    piece = (struct piece){.ticks = 533334uL, .steps = 4, .curved = true};
    check_edges_everywhere();
}

static void curved_edges_to_rest(void)
{
    piece =
        (struct piece){.ticks = 533333uL, .steps = 4, .start_speed = 8, .curved = true};
    check_edges_everywhere();
}

// Walk as the decoder does: ordinary steps in bursts, special steps one by one.
static void walk_in_bursts(uint32_t *places)
{
    struct walk walk = {0};
    uint32_t at = 0;
    uint16_t k = 1;

    walk_start(&walk, &piece);
    while (!walk_done(&walk)) {
        uint8_t count = (uint8_t)walk_burst(&walk);
        uint32_t sum = 0;
        for (uint8_t i = 0; i < count; i++, k++) {
            sum += even_next(&walk.steps.even);
            places[k] = at + sum;
        }
        walk_skip(&walk, count, sum);
        at += sum;
        at += walk_next(&walk);
        places[k] = at;
        k++;
    }
    TEST_ASSERT_EQUAL_UINT16(piece.steps + 1u, k);
}

static void bursts_and_single_steps_agree(void)
{
    piece = (struct piece){.ticks = 533333uL, .steps = STEPS_MAX, .has_edge = true};
    for (uint16_t k = 0; k < STEPS_MAX; k++) {
        piece.edge_steps = k;
        piece.edge_ticks = (uint32_t)13333u * k + 5000u;
        walk_through(walked_ticks);
        walk_in_bursts(plain_ticks);
        TEST_ASSERT_EQUAL_UINT32_ARRAY(&walked_ticks[1], &plain_ticks[1], STEPS_MAX);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(last_step_at_the_end);
    RUN_TEST(one_step);
    RUN_TEST(even_edges);
    RUN_TEST(many_even_edges);
    RUN_TEST(two_steps);
    RUN_TEST(curved_edges);
    RUN_TEST(curved_edges_from_rest);
    RUN_TEST(curved_edges_to_rest);
    RUN_TEST(bursts_and_single_steps_agree);
    return UNITY_END();
}
