// SPDX-License-Identifier: MIT
// pixstep-plan: the edges that a board will make, from the same core, without a board. Segments go
// through the board's own check, decoder and ring; a loop in place of the step interrupt reads the
// ring.
//
//   stdin    one segment in each row: "count repeat"
//   stdout   CSV step,tick (tick 0 = line zero) or with --pixels pixel,tick,expected_steps
//   exit     0 done, 2 refused or wrong use (one line on stderr)
#include <getopt.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/require.h"
#include "motion/axis.h"
#include "motion/decode.h"

#define QUEUE_SLOTS   128u
#define DECODE_BUDGET 64u
#define DELAY_TICKS   1000u

struct options {
    uint32_t hz_num;
    uint32_t hz_den;
    uint32_t timer_hz;
    uint16_t min_interval_ticks;
    uint16_t backlash_steps;
    uint16_t line_speed;
    bool smooth;
    bool negative;
    bool pixels;
};

struct plan {
    struct step_ring ring;
    struct options options;
    struct pixel_period period;
    struct line_limits limits;
    struct axis axis;
    struct segment slots[QUEUE_SLOTS];
    struct step_engine engine;
    uint64_t now_ticks; // start of the period about to be loaded
    uint64_t zero_ticks;
    int32_t steps;
    uint32_t pixels_printed;
    uint16_t warned;
    bool released;
};

static _Noreturn void fail(const char *text)
{
    fprintf(stderr, "%s\n", text);
    exit(2);
}

void require_failed(uint16_t line)
{
    fprintf(stderr, "internal: broken promise at line %u\n", line);
    exit(2);
}

static const char *error_name(unsigned code)
{
    switch (code) {
#define LINE_ERROR(number, name, text, cure)                                             \
    case (number):                                                                       \
        return #name;
#include "motion/line_errors.def"
#undef LINE_ERROR
    default:
        return "unknown";
    }
}

static const char *error_text(unsigned code)
{
    switch (code) {
#define LINE_ERROR(number, name, text, cure)                                             \
    case (number):                                                                       \
        return text;
#include "motion/line_errors.def"
#undef LINE_ERROR
    default:
        return "unknown";
    }
}

static void report(const char *what, unsigned code, uint32_t pixel)
{
    fprintf(stderr,
            "%s: %s at pixel %u: %s\n",
            what,
            error_name(code),
            (unsigned)pixel,
            error_text(code));
}

// Print the pixel edges that the ledger has recorded since the last call.
static void print_pixels(struct plan *plan, struct pixel_grid *grid, uint64_t *edge)
{
    const struct ledger *ledger = &plan->axis.ledger;

    while (plan->pixels_printed != ledger->pixel) {
        uint32_t behind = ledger->pixel - plan->pixels_printed; // 1: the newest record
        struct pixel_record record =
            records_get(&ledger->records, (uint8_t)(ledger->records.count - behind));

        *edge += pixel_grid_advance(grid);
        plan->pixels_printed++;
        if (record.actual_steps != record.expected_steps) {
            fail("internal: expected and actual position differ");
        }
        printf("%u,%llu,%d\n",
               (unsigned)plan->pixels_printed,
               (unsigned long long)*edge,
               (int)record.expected_steps);
    }
}

// Load one period as the step interrupt would do.
static void load_period(struct plan *plan)
{
    struct step_load load = step_engine_next(&plan->engine, &plan->ring);

    if (load.pulse) {
        plan->steps++;
        if (!plan->options.pixels) {
            printf("%d,%lld\n",
                   (int)plan->steps,
                   (long long)(plan->now_ticks - plan->zero_ticks));
        }
    }
    plan->now_ticks += (uint64_t)load.top_ticks + 1u;
}

static void follow(struct plan *plan)
{
    struct engine_sample sample = step_engine_sample(&plan->engine);

    ledger_advance(&plan->axis.ledger, &plan->axis.feed.stream, &sample, LEDGER_EXACTLY);
}

static void release(struct plan *plan)
{
    struct feed *feed = &plan->axis.feed;

    plan->zero_ticks = plan->now_ticks + DELAY_TICKS;
    feed_release(feed, feed->lead_in_ticks + DELAY_TICKS);
    axis_place(&plan->axis, (uint32_t)plan->zero_ticks);
    plan->released = axis_released(&plan->axis);
}

// Decode, let the stand-in of the interrupt take one period, and print new edges, until the line is
// over or needs more entries.
static void run_line(struct plan *plan,
                     struct pixel_grid *grid,
                     uint64_t *edge,
                     bool last)
{
    while (plan->axis.phase != DECODE_OUTSIDE || axis_ring_fill(&plan->axis) != 0) {
        decode_axis(&plan->axis, &plan->period, true, DECODE_BUDGET);
        if (plan->axis.phase == DECODE_DRY && !last &&
            axis_ring_fill(&plan->axis) < 128u) {
            return;
        }
        if (!plan->released) {
            release(plan);
        }
        load_period(plan);
        follow(plan);
        if (plan->options.pixels) {
            print_pixels(plan, grid, edge);
        }
    }
}

static void queue_entry(struct plan *plan, int32_t count, uint32_t repeat)
{
    uint8_t bytes[4] = {(uint8_t)((uint32_t)count >> 8),
                        (uint8_t)count,
                        (uint8_t)(repeat >> 8),
                        (uint8_t)repeat};
    struct axis *axis = &plan->axis;
    uint32_t pixel = axis->check.pixel + 1u;

    enum block_result result =
        axis_queue_block(axis, &plan->limits, axis->next_block, bytes, 1);
    if (result == BLOCK_REFUSED) {
        report("line refused", axis->line_error, axis->line_error_pixel);
        exit(2);
    }
    if (result != BLOCK_TAKEN) {
        fail("internal: block not taken");
    }
    if (axis->check.warning != 0 && !plan->warned) {
        report("warning", axis->check.warning, pixel);
        plan->warned = true;
    }
}

// Read a whole number and skip the blanks behind it; *text moves behind them.
static bool take_number(const char **text, long min, long max, long *value)
{
    char *end = NULL;

    *value = strtol(*text, &end, 10);
    if (end == *text || *value < min || *value > max) {
        return false;
    }
    while (*end == ' ' || *end == '\t' || *end == '\r' || *end == '\n') {
        end++;
    }
    *text = end;
    return true;
}

static bool read_run(int32_t *count, uint32_t *repeat)
{
    static unsigned line;
    char text[64];
    const char *rest = text;
    long a = 0;
    long b = 0;

    if (fgets(text, sizeof text, stdin) == NULL) {
        return false;
    }
    line++;
    if (!take_number(&rest, INT16_MIN, INT16_MAX, &a) ||
        !take_number(&rest, 1, UINT16_MAX, &b) || *rest != '\0') {
        fprintf(stderr, "stdin:%u: not a run \"count repeat\": %s", line, text);
        exit(2);
    }
    *count = (int32_t)a;
    *repeat = (uint32_t)b;
    return true;
}

static void plan_line(struct plan *plan)
{
    const struct options *options = &plan->options;
    struct pixel_grid grid;
    uint64_t edge = 0;
    int32_t count = 0;
    uint32_t repeat = 0;
    uint16_t word = (uint16_t)(LINE_MARK_START | LINE_START_WAIT |
                               (options->smooth ? LINE_START_SMOOTH : 0u) |
                               (options->negative ? LINE_START_NEGATIVE : 0u));

    pixel_grid_start(&grid, &plan->period);
    puts(options->pixels ? "pixel,tick,expected_steps" : "step,tick");
    queue_entry(plan, word, 0);
    queue_entry(plan, options->backlash_steps, options->line_speed);
    (void)lifecycle_report(&plan->axis.life, LIFECYCLE_READY);
    while (read_run(&count, &repeat)) {
        queue_entry(plan, count, repeat);
        if (plan->axis.phase == DECODE_OUTSIDE) {
            (void)lifecycle_report(&plan->axis.life, LIFECYCLE_READY);
            (void)axis_arm(&plan->axis, &plan->period, true);
        }
        run_line(plan, &grid, &edge, false);
    }
    queue_entry(plan, (int32_t)LINE_MARK_END, 0);
    if (plan->axis.phase != DECODE_OUTSIDE) {
        run_line(plan, &grid, &edge, true);
    }
}

static uint32_t number(const char *text, const char *option, uint32_t max)
{
    char *end = NULL;
    unsigned long long value = strtoull(text, &end, 10);

    if (*text == '\0' || *text == '-' || *end != '\0' || value > max) {
        fprintf(
            stderr, "--%s: not a number from 0 to %u: %s\n", option, (unsigned)max, text);
        exit(2);
    }
    return (uint32_t)value;
}

static void set_hz(struct options *options, const char *text)
{
    char *slash = strchr(text, '/');
    char whole[32] = {0};

    if (slash == NULL || (size_t)(slash - text) >= sizeof whole) {
        fail("--hz: write numerator/denominator, for example 30/1 or 30000/1001");
    }
    memcpy(whole, text, (size_t)(slash - text));
    options->hz_num = number(whole, "hz", UINT32_MAX);
    options->hz_den = number(slash + 1, "hz", UINT32_MAX);
}

static void set_decode(struct options *options, const char *text)
{
    if (strcmp(text, "smooth") != 0 && strcmp(text, "plain") != 0) {
        fail("--decode: smooth or plain");
    }
    options->smooth = text[0] == 's';
}

static void usage(void)
{
    fail("use: pixstep-plan --hz N/D --timer-hz F --decode smooth|plain [--backlash B"
         " --line-speed V]\n     [--min-interval T] [--negative] [--pixels] < runs");
}

static void set_option(struct options *options, int option)
{
    switch (option) {
    case 'h':
        set_hz(options, optarg);
        break;
    case 't':
        options->timer_hz = number(optarg, "timer-hz", UINT32_MAX);
        break;
    case 'd':
        set_decode(options, optarg);
        break;
    case 'b':
        options->backlash_steps = (uint16_t)number(optarg, "backlash", UINT16_MAX);
        break;
    case 'v':
        options->line_speed = (uint16_t)number(optarg, "line-speed", UINT16_MAX);
        break;
    case 'm':
        options->min_interval_ticks =
            (uint16_t)number(optarg, "min-interval", UINT16_MAX);
        break;
    case 'n':
        options->negative = true;
        break;
    case 'p':
        options->pixels = true;
        break;
    default:
        usage();
    }
}

static void parse(struct options *options, int argc, char **argv)
{
    static const struct option names[] = {
        {"hz", required_argument, NULL, 'h'},
        {"timer-hz", required_argument, NULL, 't'},
        {"decode", required_argument, NULL, 'd'},
        {"backlash", required_argument, NULL, 'b'},
        {"line-speed", required_argument, NULL, 'v'},
        {"pixels", no_argument, NULL, 'p'},
        {"negative", no_argument, NULL, 'n'},
        {"min-interval", required_argument, NULL, 'm'},
        {NULL, 0, NULL, 0},
    };
    int option;

    *options = (struct options){.min_interval_ticks = 64u};
    while ((option = getopt_long(argc, argv, "", names, NULL)) != -1) {
        set_option(options, option);
    }
    if (options->hz_num == 0 || options->timer_hz == 0 || optind != argc) {
        usage();
    }
}

static uint16_t reversal_ticks(const struct options *options)
{
    uint32_t ticks = 4u * (uint32_t)options->min_interval_ticks;

    return ticks > UINT16_MAX ? UINT16_MAX : (uint16_t)ticks;
}

int main(int argc, char **argv)
{
    static struct plan plan;

    parse(&plan.options, argc, argv);
    if (!pixel_period_set(&plan.period,
                          plan.options.timer_hz,
                          plan.options.hz_num,
                          plan.options.hz_den)) {
        fail("--hz: the pixel period must be 1024 to 16777215 timer ticks");
    }
    plan.limits = (struct line_limits){
        .pixel_ticks = plan.period.whole_ticks,
        .min_interval_ticks = plan.options.min_interval_ticks,
        .smooth_min_interval_ticks = plan.options.min_interval_ticks,
        .reversal_min_ticks = reversal_ticks(&plan.options),
    };
    step_engine_reset(&plan.engine, &plan.ring);
    const struct axis_parts parts = {
        .ring = &plan.ring,
        .trains = plan.engine.trains,
        .slots = plan.slots,
        .slot_count = QUEUE_SLOTS,
        .first_period_ticks = STEP_IDLE_TICKS,
    };
    axis_init(&plan.axis, &parts);
    plan.axis.feed.reversal_ticks = plan.limits.reversal_min_ticks / 2u;
    plan.now_ticks = STEP_IDLE_TICKS;
    plan_line(&plan);
    return 0;
}
