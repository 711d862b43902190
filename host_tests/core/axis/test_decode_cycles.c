// SPDX-License-Identifier: MIT
// Budgets of decoding on a board: cycles for each step by kind of piece, and cycles for a new piece
// before its first step. Natively no cycles are counted, and every budget holds.
#include <stdint.h>

#include "line/line.h"
#include "ring/step_ring.h"
#include "steps/walk.h"
#include "unity.h"

#define BATCH  48u
#define COUNTS 9u

static struct curve curve;
static struct step_ring ring;

#ifdef __AVR__
#include <avr/io.h>

// Timer 1 free running at the CPU clock: mode 15 with the highest TOP, which the simulator counts
// exactly.
void setUp(void)
{
    OCR1A = 0xFFFFu;
    TCCR1A = (uint8_t)((1u << WGM11) | (1u << WGM10));
    TCCR1B = (uint8_t)((1u << WGM13) | (1u << WGM12) | (1u << CS10));
}

static uint16_t now(void)
{
    return TCNT1;
}

#else

void setUp(void)
{
}

static uint16_t now(void)
{
    return 0;
}

#endif

void tearDown(void)
{
}

struct count {
    uint32_t batch_cycles; // cycles of all batches together
    uint16_t batch_steps;
    uint32_t slow_cycles; // cycles of all steps that were in no batch
    uint16_t slow_steps;
};

static void count_batch(struct count *count, uint16_t left, struct curve_made *made)
{
    uint8_t wanted = (uint8_t)(left < BATCH ? left : BATCH);
    uint16_t start = now();

    curve_burst(&curve, &ring, 0, wanted, made);
    uint16_t cycles = (uint16_t)(now() - start);
    if (made->steps != 0) {
        count->batch_cycles += cycles;
        count->batch_steps = (uint16_t)(count->batch_steps + made->steps);
    }
}

static void count_slow(struct count *count)
{
    uint16_t start = now();

    (void)curve_next(&curve);
    uint16_t cycles = (uint16_t)(now() - start);
    count->slow_cycles += cycles;
    count->slow_steps++;
}

static struct count count_piece(uint32_t ticks, uint16_t speed, uint16_t steps)
{
    struct count count = {0};
    struct curve_made made;

    curve_start(&curve, ticks, speed, steps);
    for (uint16_t k = 1; k < steps; k = (uint16_t)(k + made.steps)) {
        count_batch(&count, (uint16_t)(steps - k), &made);
        if (made.steps == 0) {
            made.steps = 1;
            count_slow(&count);
        }
    }
    return count;
}

// Both in cycles a step; what a piece does not have costs nothing.
static void check_piece(uint32_t ticks,
                        uint16_t speed,
                        uint16_t steps,
                        uint16_t batch_budget,
                        uint16_t slow_budget)
{
    struct count count = count_piece(ticks, speed, steps);

    TEST_ASSERT_LESS_OR_EQUAL_UINT32((uint32_t)batch_budget * count.batch_steps,
                                     count.batch_cycles);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32((uint32_t)slow_budget * count.slow_steps,
                                     count.slow_cycles);
}

static void flat_narrow(void)
{
    check_piece(533333uL, 896, 948, 50, 0);
    check_piece(533333uL, 1000, 999, 50, 0);
    check_piece(533333uL, 999, 1000, 50, 0);
    check_piece(533333uL, 600, 660, 58, 0);
    check_piece(533333uL, 1000, 940, 58, 0);
    check_piece(533333uL, 450, 490, 66, 0);
    check_piece(53333uL, 100, 104, 76, 0);
}

static void flat_wide(void)
{
    check_piece(533333uL, 1596, 1648, 69, 0);
    check_piece(533333uL, 2600, 2599, 62, 0);
    check_piece(0xFFFFFFuL, 9000, 8960, 72, 0);
    check_piece(0xFFFFFFuL, 600, 601, 80, 0);
}

// All of it steep, then steep at one end only.
static void steep(void)
{
    check_piece(533333uL, 150, 190, 190, 0);
    check_piece(533333uL, 200, 240, 190, 0);
    check_piece(533333uL, 240, 200, 190, 0);
    check_piece(533333uL, 111, 166, 185, 0);
    check_piece(533333uL, 0, 500, 190, 1200);
    check_piece(533333uL, 1000, 500, 195, 1200);
    check_piece(533333uL, 0, 700, 185, 1250);
    check_piece(160000uL, 30, 35, 195, 0);
    check_piece(160000uL, 45, 40, 195, 0);
    check_piece(160000uL, 60, 65, 205, 0);
}

// The first pixels from rest, the last pixels to rest, and pixels for which 40 bits are not enough.
static void slow(void)
{
    check_piece(533333uL, 0, 4, 0, 1800);
    check_piece(533333uL, 8, 4, 0, 1800);
    check_piece(533333uL, 8, 12, 0, 1300);
    check_piece(533333uL, 16, 30, 460, 1100);
    check_piece(533333uL, 44, 86, 215, 1100);
    check_piece(0xFFFFFFuL, 60, 160, 0, 1000);
    check_piece(0xFFFFFFuL, 6000, 6100, 570, 0);
}

static struct pixel_period period;
static uint8_t slots[64];
static struct segment_queue queue;
static struct line line;
static struct walk walk;

static void push(int16_t count, uint16_t repeat)
{
    (void)segment_queue_push(&queue, (struct segment){.count = count, .repeat = repeat});
}

// A ramp like that of the worked example, with backlash: the line is shifted, which takes two grids
// and puts an edge inside every pixel.
static void check_new_pieces(uint16_t backlash, uint16_t budget)
{
    static const int16_t counts[COUNTS] = {4, 12, 58, 142, 232, 322, 412, 456, 456};
    struct piece piece;

    (void)pixel_period_set(&period, 16000000uL, 30, 1);
    segment_queue_init(&queue, slots, sizeof slots);
    push(LINE_MARK_START | LINE_START_SMOOTH, 0);
    push((int16_t)backlash, 912);
    push(0, 1);
    for (uint8_t i = 0; i < COUNTS; i++) {
        push(counts[i], 1);
    }
    line_begin(&line, &period, &queue);
    TEST_ASSERT_EQUAL_INT(LINE_PIECE, line_next(&line, &piece));
    for (uint8_t i = 0; i < COUNTS; i++) {
        uint16_t start = now();
        enum line_status status = line_next(&line, &piece);
        walk_start(&walk, &piece);
        uint16_t cycles = (uint16_t)(now() - start);
        TEST_ASSERT_EQUAL_INT(LINE_PIECE, status);
        TEST_ASSERT_LESS_OR_EQUAL_UINT16(budget, cycles);
    }
}

static void new_piece(void)
{
    check_new_pieces(0, 3800);
    check_new_pieces(250, 5000);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(flat_narrow);
    RUN_TEST(flat_wide);
    RUN_TEST(steep);
    RUN_TEST(slow);
    RUN_TEST(new_piece);
    return UNITY_END();
}
