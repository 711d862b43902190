// SPDX-License-Identifier: MIT
// Measures the cycle tables at the heads of the assembly files, to the cycle. Only for the AVR.
#include <stdint.h>
#include <string.h>

#include "unity.h"

#ifdef __AVR__
#include <avr/io.h>

#include "account/ledger.h"
#include "base/divide.h"
#include "base/multiply.h"
#include "base/wide.h"
#include "clock/pixel_period.h"
#include "line/line.h"
#include "ring/step_ring.h"
#include "ring/step_ring_sum.h"
#include "steps/curve_flat.h"
#include "steps/curve_steep.h"
#include "steps/even_pixel.h"

// Routines that inline functions call.
uint32_t multiply_in_registers(uint32_t a, uint16_t b);
struct wide wide_times_in_registers(struct wide a, uint16_t factor);
// Only curve_flat.c and curve_steep.c declare these routines. The tests ignore the results of the
// first two.
void curve_flat_narrow(struct curve_flat *flat, volatile uint8_t *low, uint8_t count);
void curve_flat_wide(struct curve_flat *flat, volatile uint8_t *low, uint8_t count);
uint8_t curve_steep_steps(struct curve_steep *steep,
                          volatile uint8_t *low,
                          uint8_t count);
uint32_t curve_steep_fit(struct curve_steep *steep, uint32_t ticks);
uint16_t curve_steep_root(uint32_t value);

// Cycles of `call` and `ret` together on the ATmega2560.
#define CALL_AND_RETURN 10u
// A part with up to 128 KB of flash keeps return addresses of two bytes instead of three: `call`
// and `ret` take one cycle less each.
#if defined(__AVR_3_BYTE_PC__)
#define CALL_LESS 0u
#else
#define CALL_LESS 2u
#endif
// pixel_grid_advance() with the call, and a pixel in ledger_pass_waypoints().
#define GRID_CYCLES  76u
#define WHOLE_CYCLES 40u // where the period is a whole number of ticks
#define PIXEL_CYCLES 241u
// Pixels whose records are not kept.
#define PASSING_CYCLES 216u
// Whole pixels of up to 24 steps in even_pixels_write().
#define EVEN_CYCLES     320u // with a segment of its own, and
#define SAME_CYCLES     242u // inside a run, besides its steps; up to
#define GROUPS_CYCLES   8u   // less, as the steps make groups of one, two, four and eight
#define EQUAL_CYCLES    4u   // a step where all are equally long
#define MIXED_CYCLES    2u   // more for a pixel where some are a tick longer:
#define SHORT_CYCLES    6u   // a step of those,
#define LONG_CYCLES     10u  // a longer one
#define FRACTION_CYCLES 30u  // more where the grid has fractions of 16 bits,
#define WIDE_FRACTION_CYCLES 90u // or of more
// Of a step: the low byte of q - 1 stays far from a carry.
#define TOP 0x0140u

typedef uint32_t product_function(uint32_t a, uint16_t b);
typedef uint16_t divide_function(uint32_t value, uint16_t divisor);
typedef struct quotient quotient_function(uint16_t high, uint16_t low, uint16_t divisor);
typedef struct wide wide_function(struct wide a, uint16_t factor);
typedef uint16_t root_function(uint32_t value);
typedef uint32_t fit_function(struct curve_steep *steep, uint32_t ticks);
typedef uint32_t grid_function(struct pixel_grid *grid);
typedef void flat_function(struct curve_flat *flat, volatile uint8_t *low, uint8_t count);

static struct step_ring ring;
static volatile uint32_t result;

// Returns at once: the cost of a measurement itself is measured with this function.
__attribute__((naked)) static void nothing(void)
{
    __asm__ volatile("ret");
}

static uint16_t now(void)
{
    return TCNT1;
}

// Timer 1 free running at the CPU clock: mode 15 with the highest TOP, which the simulator counts
// exactly.
void setUp(void)
{
    OCR1A = 0xFFFFu;
    TCCR1A = (uint8_t)((1u << WGM11) | (1u << WGM10));
    TCCR1B = (uint8_t)((1u << WGM13) | (1u << WGM12) | (1u << CS10));
}

#define MEASURING __attribute__((noinline, noclone)) static uint16_t

MEASURING time_product(product_function *function, uint32_t a, uint16_t b)
{
    uint16_t start = now();

    result = function(a, b);
    return (uint16_t)(now() - start);
}

MEASURING time_divide(divide_function *function, uint32_t value, uint16_t divisor)
{
    uint16_t start = now();

    result = function(value, divisor);
    return (uint16_t)(now() - start);
}

MEASURING
time_quotient(quotient_function *function, uint16_t high, uint16_t low, uint16_t divisor)
{
    uint16_t start = now();

    result = function(high, low, divisor).rest;
    return (uint16_t)(now() - start);
}

MEASURING time_wide(wide_function *function, struct wide a, uint16_t factor)
{
    uint16_t start = now();

    result = (uint32_t)function(a, factor).high;
    return (uint16_t)(now() - start);
}

MEASURING time_root(root_function *function, uint32_t value)
{
    uint16_t start = now();

    result = function(value);
    return (uint16_t)(now() - start);
}

MEASURING time_fit(fit_function *function, struct curve_steep *steep, uint32_t ticks)
{
    uint16_t start = now();

    result = function(steep, ticks);
    return (uint16_t)(now() - start);
}

MEASURING time_flat(flat_function *function, struct curve_flat flat, uint8_t count)
{
    uint16_t start = now();

    function(&flat, ring.low, count);
    return (uint16_t)(now() - start);
}

MEASURING time_steep(struct curve_steep steep, uint8_t count)
{
    uint16_t start = now();

    (void)curve_steep_steps(&steep, ring.low, count);
    return (uint16_t)(now() - start);
}

MEASURING time_sum(uint8_t count)
{
    uint8_t slot = 0;
    uint16_t start = now();

    result = step_ring_sum(&ring, &slot, count);
    return (uint16_t)(now() - start);
}

static uint16_t product_cycles(product_function *function, uint32_t a, uint16_t b)
{
    uint16_t own = time_product((product_function *)nothing, a, b);

    return (uint16_t)(time_product(function, a, b) - own + CALL_AND_RETURN);
}

static uint16_t quotient_cycles(uint16_t high, uint16_t low, uint16_t divisor)
{
    uint16_t own = time_quotient((quotient_function *)nothing, high, low, divisor);

    return (uint16_t)(time_quotient(divide_with_rest, high, low, divisor) - own +
                      CALL_AND_RETURN);
}

static uint16_t root_cycles(uint32_t value)
{
    uint16_t own = time_root((root_function *)nothing, value);

    return (uint16_t)(time_root(curve_steep_root, value) - own + CALL_AND_RETURN);
}

static uint16_t divide_cycles(uint32_t value, uint16_t divisor)
{
    uint16_t own = time_divide((divide_function *)nothing, value, divisor);

    return (uint16_t)(time_divide(divide_u32_u16, value, divisor) - own +
                      CALL_AND_RETURN);
}

static void products(void)
{
    struct wide a = wide_from(0x123456789A);
    uint16_t own = time_wide((wide_function *)nothing, a, 0xABCD);
    uint16_t cycles = (uint16_t)(time_wide(wide_times_in_registers, a, 0xABCD) - own);

    TEST_ASSERT_EQUAL_UINT16(53, cycles + CALL_AND_RETURN);
    TEST_ASSERT_EQUAL_UINT16(40,
                             product_cycles(multiply_in_registers, 0x12345678uL, 0xABCD));
}

// First no bit of the quotient is set, then every bit is.
static void quotients(void)
{
    TEST_ASSERT_EQUAL_UINT16(202, quotient_cycles(0, 0, 1));
    TEST_ASSERT_EQUAL_UINT16(234, quotient_cycles(0x3FFF, 0xC000, 0x4000));
    TEST_ASSERT_EQUAL_UINT16(212u - CALL_LESS, divide_cycles(0, 1));
    TEST_ASSERT_EQUAL_UINT16(244u - CALL_LESS, divide_cycles(0x3FFFC000uL, 0x4000));
}

static void roots(void)
{
    TEST_ASSERT_EQUAL_UINT16(367, root_cycles(0));
    TEST_ASSERT_EQUAL_UINT16(431, root_cycles(0xFFFFFFFFuL));
}

// The residual is 0, and a guess of `ticks` is right.
static struct curve_steep steep_at(uint32_t difference, uint32_t ticks, int16_t half)
{
    uint64_t step = (uint64_t)difference * ticks;
    int32_t slope = (int32_t)difference - half * ((int32_t)ticks - 1);

    return (struct curve_steep){
        .at = {.slope = wide_from_int32(slope),
               .step_low = (uint16_t)step,
               .step = (uint32_t)(step >> 16),
               .half = half},
        .last_ticks = ticks,
        .good = true,
    };
}

// The guess is right.
#define FIT (94u + 145u + 25u)

static uint16_t fit_cycles(uint32_t ticks, uint32_t guess, int16_t half)
{
    struct curve_steep steep = steep_at(0x10000uL, ticks, half);
    uint16_t own = time_fit((fit_function *)nothing, &steep, guess);
    uint16_t cycles = time_fit(curve_steep_fit, &steep, guess);

    TEST_ASSERT_EQUAL_UINT32(ticks, result);
    return (uint16_t)(cycles - own + CALL_AND_RETURN);
}

static void fits(void)
{
    TEST_ASSERT_EQUAL_UINT16(FIT, fit_cycles(1000, 1000, 0));
    TEST_ASSERT_EQUAL_UINT16(FIT + 3, fit_cycles(1000, 1000, -5));
    TEST_ASSERT_EQUAL_UINT16(FIT + 17, fit_cycles(100000uL, 100000uL, 0));
    TEST_ASSERT_EQUAL_UINT16(FIT + 145 + 29 + 42, fit_cycles(1000, 1001, 0));
    TEST_ASSERT_EQUAL_UINT16(FIT + 145 + 33, fit_cycles(1000, 999, 0));
    TEST_ASSERT_EQUAL_UINT16(FIT + 145 + 29 + 3 * 42, fit_cycles(1000, 1007, 0));
}

// The cost of one more step, where no sum of ticks carries.
static uint16_t steep_step_cycles(int32_t change, uint8_t count)
{
    struct curve_steep steep = steep_at(0x2000000uL, 1000, 0);

    steep.change = change;
    return (uint16_t)(time_steep(steep, (uint8_t)(count + 1u)) -
                      time_steep(steep, count));
}

static uint16_t steep_miss_cycles(int32_t miss)
{
    struct curve_steep right = steep_at(0x2000000uL, 1000, 0);
    struct curve_steep wrong = right;

    wrong.change = miss;
    return (uint16_t)(time_steep(wrong, 1) - time_steep(right, 1));
}

static void steep_steps(void)
{
    TEST_ASSERT_EQUAL_UINT16(129, steep_step_cycles(0, 2));
    TEST_ASSERT_EQUAL_UINT16(43, steep_miss_cycles(-1));
    TEST_ASSERT_EQUAL_UINT16(43 + 15, steep_miss_cycles(-2));
    TEST_ASSERT_EQUAL_UINT16(57, steep_miss_cycles(1));
    TEST_ASSERT_EQUAL_UINT16(57 + 20, steep_miss_cycles(2));
}

// Numbers for the path that a step takes: in units of the upper 16 bits of the width, with h = 0.
static struct curve_flat flat_at(flat_function *function,
                                 int32_t gain,
                                 int32_t difference)
{
    int32_t unit = function == curve_flat_narrow ? 0x100 : 0x10000;

    return (struct curve_flat){.gain = {.high = gain * unit},
                               .difference = {.high = difference * unit},
                               .top = TOP};
}

// 0 <= value < difference, in every step.
static struct curve_flat short_steps(flat_function *function)
{
    return flat_at(function, 0, 64);
}

// value < 0 <= value + difference, in every step.
static struct curve_flat long_steps(flat_function *function)
{
    return flat_at(function, -64, 64);
}

static uint16_t flat_step_cycles(flat_function *function, struct curve_flat flat)
{
    return (uint16_t)(time_flat(function, flat, 3) - time_flat(function, flat, 2));
}

static void flat_steps(void)
{
    struct curve_flat narrow = short_steps(curve_flat_narrow);
    struct curve_flat wide = short_steps(curve_flat_wide);

    TEST_ASSERT_EQUAL_UINT16(22, flat_step_cycles(curve_flat_narrow, narrow));
    TEST_ASSERT_EQUAL_UINT16(35, flat_step_cycles(curve_flat_wide, wide));
    narrow = long_steps(curve_flat_narrow);
    wide = long_steps(curve_flat_wide);
    TEST_ASSERT_EQUAL_UINT16(37, flat_step_cycles(curve_flat_narrow, narrow));
    TEST_ASSERT_EQUAL_UINT16(64, flat_step_cycles(curve_flat_wide, wide));
}

// value + difference is still negative: q + 1 for q, then a long step.
static uint16_t move_up_cycles(flat_function *function)
{
    return (uint16_t)(time_flat(function, flat_at(function, -96, 64), 1) -
                      time_flat(function, long_steps(function), 1));
}

// value is not below difference: q - 1 for q, then a short step.
static uint16_t move_down_cycles(flat_function *function)
{
    return (uint16_t)(time_flat(function, flat_at(function, 96, 64), 1) -
                      time_flat(function, short_steps(function), 1));
}

static void flat_moves(void)
{
    TEST_ASSERT_EQUAL_UINT16(39, move_up_cycles(curve_flat_narrow));
    TEST_ASSERT_EQUAL_UINT16(57, move_down_cycles(curve_flat_narrow));
    TEST_ASSERT_EQUAL_UINT16(90, move_up_cycles(curve_flat_wide));
    TEST_ASSERT_EQUAL_UINT16(109, move_down_cycles(curve_flat_wide));
}

static void ring_sum(void)
{
    TEST_ASSERT_EQUAL_UINT16(16 * 10, time_sum(12) - time_sum(2));
}

MEASURING time_grid(grid_function *function, struct pixel_grid *grid)
{
    uint16_t start = now();

    result = function(grid);
    return (uint16_t)(now() - start);
}

// Of a period of 7 ticks and `remainder` fifths.
static uint16_t grid_cycles(uint32_t remainder, uint32_t sum)
{
    const struct pixel_period period = {
        .whole_ticks = 7, .remainder = remainder, .divisor = 5};
    struct pixel_grid grid = {.period = &period, .sum = sum};
    uint16_t own = time_grid((grid_function *)nothing, &grid);
    uint16_t cycles = time_grid(pixel_grid_advance, &grid);
    uint32_t fifths = sum + remainder;

    TEST_ASSERT_EQUAL_UINT32(7u + (fifths >= 5u), result);
    TEST_ASSERT_EQUAL_UINT32(fifths >= 5u ? fifths - 5u : fifths, grid.sum);
    return (uint16_t)(cycles - own + CALL_AND_RETURN);
}

static void grids(void)
{
    TEST_ASSERT_EQUAL_UINT16(GRID_CYCLES, grid_cycles(2, 0));
    TEST_ASSERT_EQUAL_UINT16(GRID_CYCLES + 7u, grid_cycles(2, 4));
    TEST_ASSERT_EQUAL_UINT16(WHOLE_CYCLES, grid_cycles(0, 4));
}

#define PIXEL_STEPS  20u
#define ORIGIN_STEPS 1234

// Account for so many pixels of the line, of which one in `every` has a record to be kept.
MEASURING time_pixels(uint8_t count, int16_t error_ticks, uint16_t every)
{
    static struct ledger ledger;
    static struct stream stream;

    ledger_reset(&ledger, 1000);
    records_thin(every, UINT16_MAX);
    records_reset(&ledger.records);
    ledger.pulse = true;
    ledger.position_steps = ORIGIN_STEPS;
    ledger.line_origin = ORIGIN_STEPS;
    stream = (struct stream){.waypoint_placed = count};
    for (uint8_t i = 0; i < count; i++) {
        stream.waypoints[i] = (struct waypoint){
            .slot = (uint8_t)(PIXEL_STEPS * (i + 1u)),
            .way = WAYPOINT_PLAIN,
            .ticks_low = (uint16_t)(2000u + 800u * (i + 1u)),
            .position = (uint16_t)(PIXEL_STEPS * (i + 1u)),
        };
        records_note_early(&ledger.records, (uint16_t)(i + 1u), error_ticks);
    }
    uint16_t start = now();
    result = ledger_pass_waypoints(&ledger, &stream, (uint8_t)(PIXEL_STEPS * count));
    uint16_t end = now();

    TEST_ASSERT_EQUAL_INT32(ORIGIN_STEPS + (int32_t)(PIXEL_STEPS * count),
                            ledger.position_steps);
    TEST_ASSERT_EQUAL_UINT32(2000u + 800uL * count, ledger.loaded_ticks);
    TEST_ASSERT_EQUAL_UINT8(count / every, records_shown(&ledger.records));
    records_thin(1, UINT16_MAX);
    return (uint16_t)(end - start);
}

static void pixels_accounted_for(void)
{
    TEST_ASSERT_EQUAL_UINT16(PIXEL_CYCLES, time_pixels(2, 0, 1) - time_pixels(1, 0, 1));
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(PIXEL_CYCLES + 80u,
                                     time_pixels(2, 5, 1) - time_pixels(1, 5, 1));
}

static void pixels_that_pass(void)
{
    TEST_ASSERT_EQUAL_UINT16(PASSING_CYCLES,
                             time_pixels(4, 0, 100) - time_pixels(3, 0, 100));
    TEST_ASSERT_LESS_OR_EQUAL_UINT16(PASSING_CYCLES + 80u,
                                     time_pixels(4, 5, 100) - time_pixels(3, 5, 100));
}

// Of the pixels that are written: fractions of a tick.
static uint32_t even_remainder;
static uint32_t even_divisor = 1;

// Write so many pixels of 800 ticks a step; each with a segment of a byte of its own, or one run.
MEASURING time_even(uint8_t count, uint8_t steps, uint8_t more_ticks, bool run)
{
    static struct stream stream;
    static struct segment_queue queue;
    static uint8_t bytes[16];
    static struct line line;
    static struct pixel_period period;

    period = (struct pixel_period){.whole_ticks = 800u * steps + more_ticks,
                                   .remainder = even_remainder,
                                   .divisor = even_divisor};
    queue = (struct segment_queue){.out = {.bytes = bytes, .mask = 15, .last = steps},
                                   .head = run ? 0 : count};
    memset(bytes, SEGMENT_NEAR_ZERO, sizeof bytes);
    line = (struct line){.source = {.queue = &queue, .edge_open = true}};
    line.source.segment = (struct segment){.count = steps, .repeat = run ? count : 0};
    line_grid_start_exact(&line.edges, &period);
    stream = (struct stream){.ring = &ring, .waypoint_head = 1};
    uint16_t start = now();
    result = even_pixels_write(&line, &stream, false, UINT8_MAX);
    uint16_t end = now();

    TEST_ASSERT_EQUAL_UINT8(count * steps, stream.head);
    TEST_ASSERT_EQUAL_UINT8(count, stream.waypoint_placed);
    return (uint16_t)(end - start);
}

// The quotient of such a pixel is known.
static uint16_t one_even(uint8_t steps, uint8_t more_ticks, bool run)
{
    (void)time_even(1, steps, more_ticks, run);
    return time_even(3, steps, more_ticks, run) - time_even(2, steps, more_ticks, run);
}

static void even_pixels(void)
{
    for (uint8_t steps = 2; steps <= 24u; steps++) {
        uint16_t steps_cycles = EQUAL_CYCLES * steps;
        TEST_ASSERT_UINT16_WITHIN(GROUPS_CYCLES / 2u,
                                  EVEN_CYCLES - GROUPS_CYCLES / 2u + steps_cycles,
                                  one_even(steps, 0, false));
        TEST_ASSERT_UINT16_WITHIN(GROUPS_CYCLES / 2u,
                                  SAME_CYCLES - GROUPS_CYCLES / 2u + steps_cycles,
                                  one_even(steps, 0, true));
    }
}

// The first step is not in a group.
static void even_pixels_of_two_intervals(void)
{
    uint16_t equal_cycles = one_even(20, 0, true);

    for (uint8_t longer = 1; longer < 20u; longer++) {
        uint16_t short_steps = 20u - longer;
        uint16_t more_cycles = MIXED_CYCLES +
                               short_steps * (SHORT_CYCLES - EQUAL_CYCLES) +
                               (longer - 1u) * (LONG_CYCLES - EQUAL_CYCLES);
        TEST_ASSERT_EQUAL_UINT16(equal_cycles + more_cycles, one_even(20, longer, true));
    }
}

static uint16_t cycles_of_fractions(uint32_t remainder, uint32_t divisor)
{
    uint16_t whole_cycles = one_even(20, 0, true);

    even_remainder = remainder;
    even_divisor = divisor;
    uint16_t cycles = one_even(20, 0, true) - whole_cycles;
    even_remainder = 0;
    even_divisor = 1;
    return cycles;
}

static void even_pixels_of_a_grid_with_fractions(void)
{
    TEST_ASSERT_UINT16_WITHIN(10, FRACTION_CYCLES, cycles_of_fractions(1, 1000));
    TEST_ASSERT_UINT16_WITHIN(10, WIDE_FRACTION_CYCLES, cycles_of_fractions(1, 100000uL));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(products);
    RUN_TEST(quotients);
    RUN_TEST(roots);
    RUN_TEST(fits);
    RUN_TEST(steep_steps);
    RUN_TEST(flat_steps);
    RUN_TEST(flat_moves);
    RUN_TEST(ring_sum);
    RUN_TEST(grids);
    RUN_TEST(pixels_accounted_for);
    RUN_TEST(pixels_that_pass);
    RUN_TEST(even_pixels);
    RUN_TEST(even_pixels_of_two_intervals);
    RUN_TEST(even_pixels_of_a_grid_with_fractions);
    return UNITY_END();
}

#else

void setUp(void)
{
}

static void only_on_the_avr(void)
{
    TEST_IGNORE();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(only_on_the_avr);
    return UNITY_END();
}

#endif

void tearDown(void)
{
}
