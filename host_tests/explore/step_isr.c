// SPDX-License-Identifier: MIT
// firmware/avr/hal/step_isr.S in C, statement by statement; comments name the labels of the
// assembly. A C statement touches memory once where the assembly does, and this file is compiled
// like the firmware, so that there is a point before every access. Interrupts are off, except in
// call_c_nested.
#include "explore/step_isr.h"

#include <avr/io.h>
#include <stdbool.h>

#include "config.h" // CONFIG_AXES
#include "explore/part.h"
#include "explore/scene.h" // step_engines, step_rings

// As in firmware/avr/hal/step_isr.c.
struct step_engine step_engines[CONFIG_AXES];
struct step_ring step_rings[CONFIG_AXES];

void step_isr_command_0(void);
void step_isr_late_0(void);

static struct step_engine *const engine = &step_engines[0];
static const struct step_ring *const ring = &step_rings[0];

// macro give_way
static void give_way(void)
{
    TIMSK1 = (uint8_t)((TIMSK1 & ~_BV(TOIE1)) | _BV(OCIE1A));
}

// .Llate, step_isr_too_late
static void late(void)
{
    TCCR1A = (uint8_t)(_BV(WGM11) | _BV(WGM10));
    step_isr_late_0();
}

static bool is_late(void)
{
    return (TIFR1 & _BV(TOV1)) != 0;
}

// macro take_train
static void take_segment(uint8_t tail)
{
    int8_t left = (int8_t)ring->low[tail];

    engine->left = left;
    engine->tail = (uint8_t)(tail + 1u);
    uint8_t high = engine->trains[left < 0].top_high;
    engine->train_high = high;
    OCR1AH = high;
}

// .Lrefill
static void refill(void)
{
    uint8_t tail = engine->tail;

    if (ring->high[tail] == STEP_HIGH_TRAIN) {
        take_segment(tail);
    }
}

// macros train_period, train_interval, train_leave
static void train_period(int8_t left)
{
    struct pulse_train *train = &engine->trains[left < 0];
    int16_t sum = train->sum;
    bool is_long = sum >= 0;

    OCR1AL = is_long ? train->long_low : train->short_low;
    if (is_late()) {
        late();
        return;
    }
    train->sum = (int16_t)(sum + (is_long ? train->after_long : train->after_short));
    left = (int8_t)(left < 0 ? left + 1 : left - 1);
    engine->left = left;
    if (left == 0) {
        refill();
    }
}

// .Lloaded
static void loaded(void)
{
    if (is_late()) {
        late();
    }
}

// .Lhalt
static void halt(void)
{
    OCR1BH = 0xFF;
    OCR1BL = 0xFF;
    OCR1AH = (uint8_t)((STEP_IDLE_TICKS - 1u) >> 8);
    OCR1AL = (uint8_t)(STEP_IDLE_TICKS - 1u);
    if (is_late()) {
        late();
        return;
    }
    engine->state = STEP_ENGINE_HALTED;
    engine->pulse = false;
    engine->idle_count = (uint16_t)(engine->idle_count + 1u);
    TIFR1 = (uint8_t)_BV(OCF1A);
    give_way();
}

// macro halt_if_requested
static void halt_if_requested(void)
{
    if (engine->stop) {
        engine->cut = engine->left;
        engine->left = 0;
        engine->state = STEP_ENGINE_HALTING;
        give_way();
    }
}

// step_isr_execute, macro call_c_nested
static void execute(void)
{
    uint8_t mask = TIMSK1;

    TIMSK1 = 0;
    part_command_begins(0);
    part_sei();
    step_isr_command_0();
    part_cli();
    part_command_ends(0);
    TIMSK1 = mask;
    halt_if_requested();
    loaded();
}

// .Lcommand
static void command(uint8_t high)
{
    if (high == STEP_HIGH_COMMAND) {
        execute();
    } else if (engine->state == STEP_ENGINE_IN_LINE) {
        halt();
    } else {
        engine->idle_count = (uint16_t)(engine->idle_count + 1u);
        loaded();
    }
}

// step_isr_entry, .Lrare. Returns true when a train was taken, whose first period must be loaded.
static bool entry(void)
{
    uint8_t tail = engine->tail;
    uint8_t high = ring->high[tail];

    if (high > STEP_HIGH_TRAIN) {
        command(high);
        return false;
    }
    if (high == STEP_HIGH_TRAIN) {
        take_segment(tail);
        return true;
    }
    OCR1AH = high;
    OCR1AL = ring->low[tail];
    if (is_late()) {
        late();
        return false;
    }
    engine->tail = (uint8_t)(tail + 1u);
    return false;
}

// TIMER1_OVF_vect, .Lagain, .Lsecond
void step_isr_overflow(uint8_t axis)
{
    (void)axis;
    int8_t left = engine->left;
    if (left == 0 && entry()) {
        left = engine->left;
    }
    if (left != 0) {
        train_period(left);
    }
}

// TIMER1_COMPA_vect, macro halted_handler
void step_isr_compare_a(uint8_t axis)
{
    (void)axis;
    OCR1BH = 0xFF;
    OCR1BL = 0xFF;
    OCR1AH = (uint8_t)((STEP_IDLE_TICKS - 1u) >> 8);
    OCR1AL = (uint8_t)(STEP_IDLE_TICKS - 1u);
    TIFR1 = (uint8_t)_BV(TOV1);
    engine->state = STEP_ENGINE_HALTED;
    engine->idle_count = (uint16_t)(engine->idle_count + 1u);
}
