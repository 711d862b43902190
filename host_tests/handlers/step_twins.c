// SPDX-License-Identifier: MIT
//
// The handlers of the step timers (step_isr.S): compare A of a halted axis, and the overflow of a
// board with one axis, where a late interrupt is not made up for. That of several axes has a twin
// that knows the timer (late/step_twin.c).
#include "handlers/handler_twins.h"

#define HIGH_OFFSET  256U // struct step_ring
#define HIGH_TRAIN   0xFDU
#define HIGH_COMMAND 0xFEU
#define IN_LINE      1U
#define HALTED       2U
#define HALTING      3U
#define IDLE_TOP     4095U
#define QUIET_BYTE   0xFFU
#define PIN_FREE     0x03U // TCCRnA: mode 15, the pin is the port's

static struct board_timer timer;

static uint8_t *engine(uint16_t member)
{
    return twin_own((uint16_t)(timer.engine + member));
}

static uint16_t at(uint16_t offset)
{
    return (uint16_t)(timer.base + offset);
}

static void load_idle(void)
{
    twin_writes(at(TIMER_OCRB + 1U), QUIET_BYTE);
    twin_writes(at(TIMER_OCRB), QUIET_BYTE);
    twin_writes(at(TIMER_OCRA + 1U), IDLE_TOP >> 8);
    twin_writes(at(TIMER_OCRA), IDLE_TOP & 0xFFU);
}

static void count_idle(void)
{
    uint16_t count = (uint16_t)(timer.engine + IDLE_COUNT);

    twin_put_word(count, (uint16_t)(twin_word(count) + 1U));
}

static void prepare_engine(void)
{
    for (uint16_t member = TAIL; member < ENGINE_BYTES; member++) {
        bench_put((uint16_t)(timer.engine + member), bench_margin());
    }
}

static void halted(void)
{
    load_idle();
    twin_writes(timer.flags, 1U << OVERFLOW);
    *engine(STATE) = HALTED;
    count_idle();
}

static const struct shared_memory nothing[] = {{0, 0}};

void run_halted_handlers(unsigned runs)
{
    static const struct made_up nobody[] = {{.function = 0}};
    static const uint8_t vectors[] = {VECTORS_HALTED};

    for (unsigned axis = 0; axis < BOARD_AXES; axis++) {
        timer = board_timer(axis);
        bench_run(&(struct handler){.name = "halted axis",
                                    .vector = vectors[axis],
                                    .shared = nothing,
                                    .made_up = nobody,
                                    .prepare = prepare_engine,
                                    .twin = halted},
                  runs);
    }
}

#if BOARD_AXES == 1
static struct made_up functions[3];

// The ring's next entries of every kind.
static void prepare_ring(void)
{
    static const uint8_t kinds[] = {0, 1, 0x80, 0xFC, HIGH_TRAIN, HIGH_COMMAND, 0xFF};

    prepare_engine();
    for (unsigned i = 0; i < 256U; i++) {
        bench_put((uint16_t)(timer.ring + HIGH_OFFSET + i),
                  kinds[bench_noise() % sizeof kinds]);
        bench_put((uint16_t)(timer.ring + i), bench_margin());
    }
    if ((bench_noise() & 3U) == 0) {
        bench_put((uint16_t)(timer.engine + LEFT), 0);
    }
    bench_put(timer.flags,
              (uint8_t)(bench_noise() & ((bench_noise() & 3U) == 0 ? 0xFFU : 0xFEU)));
}

static uint8_t entry(uint16_t offset)
{
    return *twin_own((uint16_t)(timer.ring + offset + *engine(TAIL)));
}

static void take_train(void)
{
    uint8_t count = entry(0);
    uint16_t train = TRAINS + (count >= 0x80U ? TRAIN_BYTES : 0);

    *engine(LEFT) = count;
    *engine(TAIL) += 1U;
    *engine(TRAIN_HIGH) = *engine(train + TOP_HIGH);
    twin_writes(at(TIMER_OCRA + 1U), *engine(TRAIN_HIGH));
}

static void give_way(void)
{
    uint8_t mask = twin_reads(timer.mask);

    mask &= (uint8_t)~(1U << OVERFLOW);
    twin_writes(timer.mask, mask | 1U << COMPARE_A);
}

static bool is_late(void)
{
    if (!twin_has(timer.flags, OVERFLOW)) {
        return false;
    }
    twin_writes(at(TIMER_TCCRA), PIN_FREE);
    twin_calls(&functions[1]);
    return true;
}

static void train_period(uint8_t left)
{
    bool second = left >= 0x80U;
    uint16_t train = TRAINS + (second ? TRAIN_BYTES : 0);
    uint16_t sum_at = (uint16_t)(timer.engine + train);
    bool is_long = twin_word(sum_at) < 0x8000U;

    twin_writes(at(TIMER_OCRA),
                *engine((uint16_t)(train + (is_long ? LONG_LOW : SHORT_LOW))));
    if (is_late()) {
        return;
    }
    uint16_t after = twin_word((uint16_t)(sum_at + (is_long ? AFTER_LONG : AFTER_SHORT)));
    twin_put_word(sum_at, (uint16_t)(twin_word(sum_at) + after));
    left = (uint8_t)(left + (second ? 1U : 0xFFU));
    *engine(LEFT) = left;
    if (left == 0 && entry(HIGH_OFFSET) == HIGH_TRAIN) {
        take_train();
    }
}

static void execute(void)
{
    uint8_t mask = twin_reads(timer.mask);

    twin_writes(timer.mask, 0);
    twin_opens();
    twin_calls(&functions[0]);
    twin_closes();
    twin_writes(timer.mask, mask);
    if (*engine(STOP) != 0) {
        *engine(CUT) = *engine(LEFT);
        *engine(LEFT) = 0;
        *engine(STATE) = HALTING;
        give_way();
    }
    (void)is_late();
}

static void ring_is_empty(void)
{
    if (*engine(STATE) != IN_LINE) {
        count_idle();
        (void)is_late();
        return;
    }
    load_idle();
    if (!is_late()) {
        *engine(STATE) = HALTED;
        *engine(PULSE) = 0;
        count_idle();
        twin_writes(timer.flags, 1U << COMPARE_A);
        give_way();
    }
}

static void overflow(void)
{
    while (*engine(LEFT) == 0 && entry(HIGH_OFFSET) == HIGH_TRAIN) {
        take_train();
    }
    uint8_t high = entry(HIGH_OFFSET);
    if (*engine(LEFT) != 0) {
        train_period(*engine(LEFT));
    } else if (high < HIGH_TRAIN) {
        twin_writes(at(TIMER_OCRA + 1U), high);
        twin_writes(at(TIMER_OCRA), entry(0));
        if (!is_late()) {
            *engine(TAIL) += 1U;
        }
    } else if (high == HIGH_COMMAND) {
        execute();
    } else {
        ring_is_empty();
    }
}

void run_single_step_handler(unsigned runs)
{
    timer = board_timer(0);
    functions[0] = (struct made_up){.function = bench_function("step_isr_command_0"),
                                    .interrupts_on = true,
                                    .leave = prepare_engine};
    functions[1] = (struct made_up){.function = bench_function("step_isr_late_0")};
    bench_run(&(struct handler){.name = "step",
                                .vector = VECTOR_OVERFLOW,
                                .shared = nothing,
                                .made_up = functions,
                                .prepare = prepare_ring,
                                .twin = overflow},
              runs);
}
#else
void run_single_step_handler(unsigned runs)
{
    (void)runs;
}
#endif
