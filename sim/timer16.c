// SPDX-License-Identifier: MIT
//
// The counting half of the 16-bit timer model: what happens in which cycle.

#include "timer16.h"

#include <sim_regbit.h>

#include "access.h"

#define MODE_NORMAL        0
#define MODE_FAST_PWM_OCRA 15
#define COUNT_MAX          0xFFFFU

// Data sheet: the smallest TOP is 3 ("the minimum resolution allowed is 2-bit").
#define TOP_MIN 3

#define CLOCK_BITS     0x07U // CSn2:0 in TCCRnB
#define CLOCK_STOPPED  0
#define CLOCK_UNSCALED 1
#define ICES_BIT       0x40U
#define ICNC_BIT       0x80U

enum { COM_PORT = 0, COM_TOGGLE = 1, COM_CLEAR = 2, COM_SET = 3 };

unsigned timer16_com(const struct timer16 *t, int channel)
{
    return (unsigned)(t->tccra >> (6 - 2 * channel)) & 3U;
}

unsigned timer16_mode(const struct timer16 *t)
{
    return (t->tccra & 3U) | ((unsigned)(t->tccrb >> 1) & 0xCU);
}

static uint16_t top_of(const struct timer16 *t)
{
    return (timer16_mode(t) == MODE_FAST_PWM_OCRA) ? t->ocr[0] : COUNT_MAX;
}

uint16_t timer16_count(const struct timer16 *t, uint64_t cycle)
{
    return t->counting ? (uint16_t)(cycle - t->bottom) : t->frozen;
}

static void raise_unless_set(struct timer16 *t, avr_int_vector_t *vector, uint64_t cycle)
{
    if (vector->vector != 0 && avr_regbit_get(t->avr, vector->raised) == 0) {
        peripheral_raise(&t->hooks->host, t->avr, vector, cycle);
    }
}

static void set_output(struct timer16 *t, int channel, bool level, uint64_t cycle)
{
    if (t->oc_level[channel] != level) {
        t->oc_level[channel] = level;
        t->hooks->output(t->hooks->host.board, t, channel, cycle);
    }
}

static void apply_match(struct timer16 *t, int channel)
{
    uint64_t cycle = t->match_due[channel];
    unsigned com = timer16_com(t, channel);

    t->match_due[channel] = TIMER16_NEVER;
    raise_unless_set(t, &t->part->comp[channel].interrupt, cycle);
    if (com != COM_PORT && cycle != t->bottom_due) { // at BOTTOM, BOTTOM decides
        set_output(t, channel, com == COM_SET, cycle);
    }
}

static void apply_matches(struct timer16 *t, uint64_t cycle)
{
    for (int i = 0; i < TIMER16_CHANNELS; i++) {
        if (t->match_due[i] == cycle) {
            apply_match(t, i);
        }
    }
}

// Finds the first cycle, not before `from`, in which TCNT equals the compare register. The effect
// of the match comes one cycle later.
static void plan_match(struct timer16 *t, int channel, uint64_t from)
{
    uint64_t match = t->bottom + t->ocr[channel];
    bool reached = t->ocr[channel] <= top_of(t) && match >= from;

    t->match_due[channel] = (t->counting && reached) ? match + 1 : TIMER16_NEVER;
}

static void check_top(const struct timer16 *t)
{
    if (timer16_mode(t) == MODE_FAST_PWM_OCRA && t->ocr[0] < TOP_MIN) {
        peripheral_refuse(&t->hooks->host,
                          "timer %c: OCR%cA is %u at BOTTOM, mode 15 needs at least %d "
                          "(to load it before the start, write it in mode 0)",
                          t->name,
                          t->name,
                          (unsigned)t->ocr[0],
                          TOP_MIN);
    }
}

static void load_buffers(struct timer16 *t, uint64_t cycle)
{
    for (int i = 0; i < TIMER16_CHANNELS; i++) {
        t->ocr[i] = t->ocr_buffer[i];
        if (timer16_com(t, i) != COM_PORT) {
            set_output(t, i, timer16_com(t, i) == COM_CLEAR, cycle);
        }
    }
    check_top(t);
}

static void apply_bottom(struct timer16 *t)
{
    t->bottom = t->bottom_due;
    if (timer16_mode(t) == MODE_FAST_PWM_OCRA) {
        load_buffers(t, t->bottom);
    }
    for (int i = 0; i < TIMER16_CHANNELS; i++) {
        plan_match(t, i, t->bottom);
    }
    t->bottom_due = t->bottom + top_of(t) + 1U;
    raise_unless_set(t, &t->part->overflow, t->bottom);
}

static void apply_capture(struct timer16 *t)
{
    uint64_t cycle = t->capture_due;

    t->capture_due = t->second_capture_due;
    t->second_capture_due = TIMER16_NEVER;
    t->icr = timer16_count(t, cycle);
    raise_unless_set(t, &t->part->icr, cycle);
}

static uint64_t next_match(const struct timer16 *t)
{
    uint64_t due = peripheral_earlier(t->match_due[0], t->match_due[1]);

    return peripheral_earlier(due, t->match_due[2]);
}

void timer16_sync(struct timer16 *t, uint64_t cycle)
{
    for (;;) {
        uint64_t match = next_match(t);
        uint64_t count = peripheral_earlier(match, t->bottom_due);
        uint64_t due = peripheral_earlier(count, t->capture_due);

        if (due > cycle) {
            return;
        }
        if (due == match) {
            apply_matches(t, due);
        } else if (due == t->bottom_due) {
            apply_bottom(t); // before a capture in the same cycle, which then reads 0
        } else {
            apply_capture(t);
        }
    }
}

// A match that neither drives a pin nor interrupts can wait for the next sync.
static bool match_matters(const struct timer16 *t, int channel)
{
    return timer16_com(t, channel) != COM_PORT ||
           avr_regbit_get(t->avr, t->part->comp[channel].interrupt.enable) != 0;
}

static uint64_t next_due(const struct timer16 *t)
{
    uint64_t due = peripheral_earlier(t->bottom_due, t->capture_due);

    for (int i = 0; i < TIMER16_CHANNELS; i++) {
        if (t->match_due[i] < due && match_matters(t, i)) {
            due = t->match_due[i];
        }
    }
    return due;
}

static avr_cycle_count_t on_effect_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct timer16 *t = param;
    uint64_t due;

    (void)when;
    t->delivering = true;
    timer16_sync(t, avr->cycle);
    t->delivering = false;
    due = next_due(t);
    return (due == TIMER16_NEVER) ? 0 : due;
}

void timer16_schedule(struct timer16 *t)
{
    uint64_t due = next_due(t);

    if (t->delivering) {
        return;
    }
    if (due == TIMER16_NEVER) {
        avr_cycle_timer_cancel(t->avr, on_effect_due, t);
    } else {
        peripheral_schedule(t->avr, due, on_effect_due, t);
    }
}

static void plan_all(struct timer16 *t, uint64_t from)
{
    for (int i = 0; i < TIMER16_CHANNELS; i++) {
        plan_match(t, i, from);
    }
    t->bottom_due = t->counting ? t->bottom + top_of(t) + 1U : TIMER16_NEVER;
    timer16_schedule(t);
}

void timer16_set_count(struct timer16 *t, uint16_t count, uint64_t cycle)
{
    if (t->counting && timer16_mode(t) == MODE_FAST_PWM_OCRA && count >= t->ocr[0]) {
        peripheral_refuse(&t->hooks->host,
                          "timer %c: TCNT written to TOP or above while counting",
                          t->name);
    }
    t->frozen = count;
    t->blocked = !t->counting;
    t->bottom = cycle - count;
    plan_all(t, cycle + 1); // a match in the clock after the write is blocked
}

// True if the timer may count as it is set up now; otherwise refuses.
static bool may_count(const struct timer16 *t)
{
    unsigned mode = timer16_mode(t);

    if (mode != MODE_NORMAL && mode != MODE_FAST_PWM_OCRA) {
        peripheral_refuse(&t->hooks->host,
                          "timer %c: waveform mode %u is not modelled (0 and 15 are)",
                          t->name,
                          mode);
        return false;
    }
    for (int i = 0; i < TIMER16_CHANNELS; i++) {
        unsigned com = timer16_com(t, i);
        bool fine = com == COM_PORT || (mode == MODE_FAST_PWM_OCRA && com != COM_TOGGLE);

        if (!fine) {
            peripheral_refuse(
                &t->hooks->host,
                "timer %c: COM%c%c = %u in waveform mode %u is not modelled",
                t->name,
                t->name,
                'A' + i,
                com,
                mode);
            return false;
        }
    }
    check_top(t);
    return true;
}

static void start_or_stop(struct timer16 *t, uint64_t cycle)
{
    bool clocked = (t->tccrb & CLOCK_BITS) == CLOCK_UNSCALED && !t->held;
    uint64_t from = cycle;

    if (clocked && may_count(t) && !t->counting) {
        t->counting = true;
        t->bottom = cycle - t->frozen;
        from += t->blocked ? 1 : 0;
        t->blocked = false;
    } else if (!clocked && t->counting) {
        t->frozen = timer16_count(t, cycle);
        t->counting = false;
    }
    plan_all(t, from);
}

void timer16_control_changed(struct timer16 *t, uint64_t cycle)
{
    unsigned clock = t->tccrb & CLOCK_BITS;

    if (clock != CLOCK_STOPPED && clock != CLOCK_UNSCALED) {
        peripheral_refuse(&t->hooks->host,
                          "timer %c: clock select %u is not modelled (0 stopped and 1 "
                          "unscaled are)",
                          t->name,
                          clock);
    }
    start_or_stop(t, cycle);
}

void timer16_compare_changed(struct timer16 *t, int channel, uint64_t cycle)
{
    plan_match(t, channel, cycle);
    timer16_schedule(t);
}

void timer16_hold(struct timer16 *t, bool held, uint64_t cycle)
{
    if (t->held != held) {
        timer16_sync(t, cycle);
        t->held = held;
        start_or_stop(t, cycle);
    }
}

// The noise canceler ignores a level that has not lasted for its whole time: the capture of that
// level's edge is cancelled. Returns the last level before this change that did last.
static bool lasting_level(struct timer16 *t, uint64_t cycle, bool rising_wanted)
{
    bool canceled = (t->tccrb & ICNC_BIT) != 0 &&
                    cycle - t->icp_cycle < TIMER16_NOISE_CANCELER_CYCLES;

    if (!canceled) {
        return t->icp_level;
    }
    if (t->icp_level != t->icp_lasting && t->icp_level == rising_wanted) {
        t->capture_due = TIMER16_NEVER;
    }
    return t->icp_lasting;
}

// Between edges that the noise canceler lets through, each capture is over before the next edge.
static void plan_capture(struct timer16 *t, uint64_t due)
{
    if ((t->tccrb & ICNC_BIT) != 0) {
        t->capture_due = due + TIMER16_NOISE_CANCELER_CYCLES;
    } else if (t->capture_due == TIMER16_NEVER) {
        t->capture_due = due;
    } else {
        t->second_capture_due = due;
    }
    timer16_schedule(t);
}

void timer16_icp(struct timer16 *t, bool level, uint64_t cycle)
{
    bool rising_wanted = (t->tccrb & ICES_BIT) != 0;

    if (level == t->icp_level) {
        return;
    }
    t->icp_lasting = lasting_level(t, cycle, rising_wanted);
    t->icp_level = level;
    t->icp_cycle = cycle;
    if (level != t->icp_lasting && level == rising_wanted) {
        plan_capture(t, cycle + TIMER16_ICP_SYNC_CYCLES);
    }
}

void timer16_reset(struct timer16 *t)
{
    t->tccra = t->tccrb = t->temp = 0;
    t->icr = t->frozen = 0;
    t->held = t->counting = t->blocked = t->delivering = false;
    t->bottom_due = t->capture_due = t->second_capture_due = TIMER16_NEVER;
    for (int i = 0; i < TIMER16_CHANNELS; i++) {
        t->ocr[i] = t->ocr_buffer[i] = 0;
        t->oc_level[i] = false;
        t->match_due[i] = TIMER16_NEVER;
    }
}
