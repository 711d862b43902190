// SPDX-License-Identifier: MIT
// firmware/avr/hal/step_isr.S in C for a board with several axes, statement by statement; comments
// name the labels of the assembly. As in explore/step_isr.c a C statement touches memory once where
// the assembly does, and interrupts are off, except in call_c_nested. No interval here is so short
// that its interrupt could be late: the ways of step_catch_up.inc are the subject of
// host_tests/late.
#include "explore/step_isr.h"

#include <avr/io.h>
#include <stdbool.h>

#include "avr/hal/step_isr.h" // step_engines, step_rings
#include "explore/judge.h"
#include "explore/part.h"

// As in firmware/avr/hal/step_isr.c.
struct step_engine step_engines[CONFIG_AXES];
struct step_ring step_rings[CONFIG_AXES];
volatile uint8_t step_isr_last[CONFIG_AXES];
volatile uint8_t step_isr_before_low[CONFIG_AXES];
volatile uint8_t step_isr_before_high[CONFIG_AXES];

void step_isr_command_0(void);
void step_isr_command_1(void);

// What a handler works on.
struct isr {
    struct step_engine *engine;
    const struct step_ring *ring;
    struct part_timer_registers *timer;
    uint8_t axis;
};

static struct isr isr_of(uint8_t axis)
{
    return (struct isr){
        &step_engines[axis], &step_rings[axis], &part_registers.timers[axis], axis};
}

// macro give_way
static void give_way(const struct isr *isr)
{
    isr->timer->timsk = (uint8_t)((isr->timer->timsk & ~_BV(TOIE1)) | _BV(OCIE1A));
}

static void look_whether_late(const struct isr *isr)
{
    if ((isr->timer->tifr & _BV(TOV1)) != 0) {
        judge_broken(JUDGE_LATE);
    }
}

// macro take_count
static int8_t take_count(const struct isr *isr, uint8_t tail)
{
    int8_t left = (int8_t)isr->ring->low[tail];

    isr->engine->left = left;
    isr->engine->tail = (uint8_t)(tail + 1u);
    return left;
}

// macro load_train_high
static void load_train_high(const struct isr *isr, uint8_t high)
{
    isr->engine->train_high = high;
    isr->timer->temp = high;
}

// macro refill, behind an entry of the second train or of the first
static void refill(const struct isr *isr, bool second)
{
    uint8_t tail = isr->engine->tail;

    if (isr->ring->high[tail] != STEP_HIGH_TRAIN) {
        isr->engine->left = 0;
        return;
    }
    int8_t left = take_count(isr, tail);
    if ((left < 0) == second) {
        return;
    }
    uint8_t high = isr->engine->trains[!second].top_high;
    uint8_t before = isr->engine->train_high;
    if (high != before) {
        load_train_high(isr, high);
        // .Lanother_high
        step_isr_before_high[isr->axis] = before;
        step_isr_before_low[isr->axis] = step_isr_last[isr->axis];
        step_isr_last[isr->axis] = 0;
    }
}

// macros train_period, train_interval, train_advance, train_leave
static void train_period(const struct isr *isr, int8_t left)
{
    bool second = left < 0;
    struct pulse_train *train = &isr->engine->trains[second];
    int16_t sum = train->sum;
    bool is_long = sum >= 0;
    uint8_t low = is_long ? train->long_low : train->short_low;

    isr->timer->ocral = low;
    look_whether_late(isr);
    step_isr_last[isr->axis] = low;
    train->sum = (int16_t)(sum + (is_long ? train->after_long : train->after_short));
    left = (int8_t)(second ? left + 1 : left - 1);
    if (left == 0) {
        refill(isr, second);
    } else {
        isr->engine->left = left;
    }
}

// macro load_idle
static void load_idle(const struct isr *isr)
{
    isr->timer->temp = 0xFF;
    isr->timer->ocrbl = 0xFF;
    isr->timer->temp = (uint8_t)((STEP_IDLE_TICKS - 1u) >> 8);
    isr->timer->ocral = (uint8_t)(STEP_IDLE_TICKS - 1u);
}

// macro count_idle
static void count_idle(const struct isr *isr)
{
    isr->engine->idle_count = (uint16_t)(isr->engine->idle_count + 1u);
}

// .Lhalt
static void halt(const struct isr *isr)
{
    load_idle(isr);
    look_whether_late(isr);
    isr->engine->state = STEP_ENGINE_HALTED;
    isr->engine->pulse = false;
    count_idle(isr);
    isr->timer->tifr = (uint8_t)_BV(OCF1A);
    give_way(isr);
}

// macro halt_if_requested
static void halt_if_requested(const struct isr *isr)
{
    if (isr->engine->stop) {
        isr->engine->cut = isr->engine->left;
        isr->engine->left = 0;
        isr->engine->state = STEP_ENGINE_HALTING;
        give_way(isr);
    }
}

// step_isr_execute, macro call_c_nested
static void execute(const struct isr *isr)
{
    uint8_t mask = isr->timer->timsk;

    isr->timer->timsk = 0;
    part_command_begins(isr->axis);
    part_sei();
    if (isr->axis == 0) {
        step_isr_command_0();
    } else {
        step_isr_command_1();
    }
    part_cli();
    part_command_ends(isr->axis);
    isr->timer->timsk = mask;
    halt_if_requested(isr);
    look_whether_late(isr);
}

// .Lcommand
static void command(const struct isr *isr, uint8_t high)
{
    if (high == STEP_HIGH_COMMAND) {
        execute(isr);
    } else if (isr->engine->state == STEP_ENGINE_IN_LINE) {
        halt(isr);
    } else {
        count_idle(isr);
        look_whether_late(isr);
    }
}

// step_isr_entry, .Lrare. Returns true when a train was taken, whose first period must be loaded.
static bool entry(const struct isr *isr)
{
    uint8_t tail = isr->engine->tail;
    uint8_t high = isr->ring->high[tail];

    if (high > STEP_HIGH_TRAIN) {
        command(isr, high);
        return false;
    }
    if (high == STEP_HIGH_TRAIN) {
        bool second = take_count(isr, tail) < 0;
        load_train_high(isr, isr->engine->trains[second].top_high);
        step_isr_last[isr->axis] = 0;
        step_isr_before_high[isr->axis] = STEP_ISR_UNKNOWN;
        return true;
    }
    isr->timer->temp = high;
    isr->timer->ocral = isr->ring->low[tail];
    look_whether_late(isr);
    isr->engine->tail = (uint8_t)(tail + 1u);
    return false;
}

// TIMERn_OVF_vect, .Lagain, .Lsecond
void step_isr_overflow(uint8_t axis)
{
    const struct isr isr = isr_of(axis);
    int8_t left = isr.engine->left;

    if (left == 0 && entry(&isr)) {
        left = isr.engine->left;
    }
    if (left != 0) {
        train_period(&isr, left);
    }
}

// TIMERn_COMPA_vect, macro halted_handler
void step_isr_compare_a(uint8_t axis)
{
    const struct isr isr = isr_of(axis);

    load_idle(&isr);
    isr.timer->tifr = (uint8_t)_BV(TOV1);
    isr.engine->state = STEP_ENGINE_HALTED;
    count_idle(&isr);
}
