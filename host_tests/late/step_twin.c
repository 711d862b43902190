// SPDX-License-Identifier: MIT
//
// The names in comments are the labels and macros of the assembly.

#include "late/step_twin.h"

#define FLAG_OVERFLOW  0x01u
#define FLAG_CAPTURE   0x20u
#define MASK_OVERFLOW  0x01u
#define MASK_COMPARE   0x02u
#define FLAG_COMPARE   0x02u
#define CONTROL_NO_PIN 0x03u
#define QUIET          0xFFu
#define UNKNOWN        0xFFu
#define LONG_LOW       0x80u // an interval's low byte from here on is long
#define STRETCH_MIN    64u
#define MARGIN         4u
#define SINCE_MAKE_UP  43u
#define SINCE_FAST     26u
#define SINCE_HIGH     54u
#define SINCE_ANY      40u
#define SINCE_STRETCH  40u
#define CLOCK_LOOK     2u
#define AHEAD 10u // make_up and make_up_fast: from the read of the counter to its write
#define AHEAD_ANY        17u
#define AHEAD_HIGH       15u
#define HIGH_MOST_TICKS  224u
#define HIGH_MOST_MOVE   16
#define FIRST_AFTER_EDGE 2u // ticks behind the match of the STEP edge

// What one piece of the interrupt tells the piece that called it.
enum next { LEAVE, PERIOD, AGAIN, LATE, FAIL };

static uint8_t get(struct twin *t, enum twin_register which)
{
    return t->timer->read(t->timer->owner, which);
}

static void put(struct twin *t, enum twin_register which, uint8_t value)
{
    t->timer->write(t->timer->owner, which, value);
}

static bool over(struct twin *t)
{
    return (get(t, TWIN_FLAGS) & FLAG_OVERFLOW) != 0;
}

static void visit(struct twin *t, enum twin_path path)
{
    t->visited = (uint16_t)(t->visited | 1u << path);
}

// An interval of a train: which train, which of its two.
struct interval {
    struct pulse_train *train;
    bool second, is_long;
    uint8_t low;
};

static struct interval interval_of(struct twin *t, bool second)
{
    struct pulse_train *train = &t->engine.trains[second];
    bool is_long = train->sum >= 0;

    return (struct interval){
        train, second, is_long, is_long ? train->long_low : train->short_low};
}

// train_advance
static void advance(const struct interval *one)
{
    struct pulse_train *train = one->train;

    train->sum =
        (int16_t)((uint16_t)train->sum +
                  (uint16_t)(one->is_long ? train->after_long : train->after_short));
}

static int8_t counted(const struct interval *one, int8_t left)
{
    return (int8_t)(one->second ? left + 1 : left - 1);
}

// take_count
static int8_t take_count(struct twin *t)
{
    int8_t count = (int8_t)t->ring->low[t->engine.tail];

    t->engine.left = count;
    t->engine.tail = (uint8_t)(t->engine.tail + 1u);
    return count;
}

// refill: behind the last period of an entry.
static void refill(struct twin *t, bool second)
{
    if (t->ring->high[t->engine.tail] != STEP_HIGH_TRAIN) {
        t->engine.left = 0;
        return;
    }
    bool next = take_count(t) < 0;
    uint8_t high = t->engine.trains[!second].top_high;
    if (next == second || high == t->engine.train_high) {
        return;
    }
    t->before_high = t->engine.train_high;
    t->engine.train_high = high;
    put(t, TWIN_TOP_HIGH, high);
    t->before_low = t->last; // .Lanother_high
    t->last = 0;
}

// train_leave
static enum next leave(struct twin *t, const struct interval *one)
{
    t->left = counted(one, t->left);
    if (t->left == 0) {
        refill(t, one->second);
    } else {
        t->engine.left = t->left;
    }
    return LEAVE;
}

// .Lmade_up: the interval is loaded, or made up for, and the running period's flag waits.
static enum next made_up(struct twin *t, const struct interval *one)
{
    t->last = one->low;
    advance(one);
    return leave(t, one);
}

// .Lserved: the running period is the late interval, and the next one is loaded at once.
static enum next served(struct twin *t, const struct interval *one)
{
    t->left = counted(one, t->left);
    if (t->left != 0) {
        t->engine.left = t->left;
        return PERIOD;
    }
    refill(t, one->second);
    return AGAIN;
}

static enum next merge(struct twin *t, const struct interval *one)
{
    put(t, TWIN_FLAGS, FLAG_OVERFLOW);
    advance(one);
    return served(t, one);
}

static void look_for_clock(struct twin *t)
{
    if (t->has_clock && (get(t, TWIN_FLAGS) & FLAG_CAPTURE) != 0) {
        put(t, TWIN_BEFORE, 1);
    }
}

static uint8_t clock_look(const struct twin *t)
{
    return t->has_clock ? CLOCK_LOOK : 0;
}

// set_counter_high: false where it is too late.
static bool set_counter_high(struct twin *t, int back)
{
    uint8_t count = get(t, TWIN_COUNT_LOW);

    if (get(t, TWIN_COUNT_HIGH) != 0 || count < SINCE_HIGH || count >= HIGH_MOST_TICKS) {
        return false;
    }
    put(t, TWIN_COUNT_HIGH, 0);
    put(t, TWIN_COUNT_LOW, (uint8_t)(count + (int)AHEAD_HIGH - back));
    put(t, TWIN_TOP_HIGH, t->engine.train_high);
    return true;
}

// stretch: a period without an edge, `ticks` long, behind the running one. Then the wanted interval
// waits in the timer.
static bool stretch(struct twin *t, uint16_t ticks, uint8_t wanted_low)
{
    put(t, TWIN_FLAGS, FLAG_OVERFLOW);
    if (get(t, TWIN_COUNT_LOW) < SINCE_STRETCH) {
        return false;
    }
    put(t, TWIN_EDGE_HIGH, QUIET);
    put(t, TWIN_EDGE_LOW, QUIET);
    put(t, TWIN_TOP_HIGH, (uint8_t)((ticks - 1u) >> 8));
    put(t, TWIN_TOP_LOW, (uint8_t)(ticks - 1u));
    if (over(t)) {
        return false;
    }
    while (!over(t)) {
    }
    put(t, TWIN_EDGE_HIGH, 0);
    put(t, TWIN_EDGE_LOW, t->low_ticks);
    put(t, TWIN_TOP_HIGH, t->engine.train_high);
    put(t, TWIN_TOP_LOW, wanted_low);
    return true;
}

// .Lset_back: both intervals are below 256 ticks, this one longer by `longer`.
static bool set_counter(struct twin *t, const struct interval *one, int longer)
{
    uint8_t from = longer > 0 ? (uint8_t)longer : 0;
    uint8_t count;

    do {
        count = get(t, TWIN_COUNT_LOW);
        if (count < SINCE_ANY) {
            return false;
        }
    } while (count < from);
    unsigned then = count + AHEAD_ANY + MARGIN;
    if (then > UINT8_MAX || then >= one->low || then >= t->last) {
        return false;
    }
    visit(t, TWIN_SET_ANY);
    put(t, TWIN_COUNT_LOW, (uint8_t)((int)then - longer - (int)MARGIN));
    return true;
}

// The TOP of the running period. False where nothing is known of it.
static bool running_top(struct twin *t, uint16_t *top)
{
    uint8_t high = t->engine.train_high;
    uint8_t low = t->last;

    if (low == 0 && t->ring->low[(uint8_t)(t->engine.tail - 1u)] == (uint8_t)t->left) {
        if (t->before_high != 0 || t->before_low == 0) {
            return false;
        }
        visit(t, TWIN_BETWEEN_TRAINS);
        high = t->before_high;
        low = t->before_low;
    }
    *top = (uint16_t)(high << 8 | low);
    return true;
}

// .Lcatch_up
static bool catch_up(struct twin *t, const struct interval *one)
{
    uint16_t running;

    if (!running_top(t, &running)) {
        return false;
    }
    uint16_t wanted = (uint16_t)(t->engine.train_high << 8 | one->low);
    uint16_t longer = (uint16_t)(wanted - running);
    if (longer == 0) {
        visit(t, TWIN_NOTHING_TO_DO);
        return true;
    }
    if (longer >= STRETCH_MIN && longer <= INT16_MAX) {
        visit(t, TWIN_STRETCH);
        return stretch(t, longer, one->low);
    }
    if ((t->engine.train_high | running >> 8) == 0) {
        return set_counter(t, one, (int16_t)longer);
    }
    int8_t move = (int8_t)(uint8_t)longer;
    if (t->engine.train_high != running >> 8 || move < -HIGH_MOST_MOVE ||
        move > HIGH_MOST_MOVE) {
        return false;
    }
    visit(t, TWIN_MOVE_HIGH);
    return set_counter_high(t, move);
}

// .Lrarely
static enum next rarely(struct twin *t, const struct interval *one)
{
    return catch_up(t, one) ? made_up(t, one) : FAIL;
}

// .Lcleared: the flag of the running period is cleared, and its TOP a tick off.
static enum next set_by_a_tick(struct twin *t, const struct interval *one)
{
    int longer = one->is_long ? 1 : -1;

    t->last = one->low;
    advance(one);
    if (t->engine.train_high != 0) {
        if (over(t) || !set_counter_high(t, longer)) {
            return FAIL;
        }
        visit(t, TWIN_SET_HIGH);
        return served(t, one);
    }
    uint8_t count = get(t, TWIN_COUNT_LOW);
    unsigned then = count + AHEAD + MARGIN;
    if (count < SINCE_MAKE_UP + clock_look(t) || then > UINT8_MAX || then >= one->low) {
        return FAIL;
    }
    visit(t, TWIN_SET);
    put(t, TWIN_COUNT_LOW, (uint8_t)((int)(count + AHEAD) - longer));
    look_for_clock(t);
    return served(t, one);
}

// .Lequal
static enum next made_up_equal(struct twin *t, const struct interval *one)
{
    visit(t, TWIN_EQUAL);
    if (one->low < LONG_LOW) {
        return merge(t, one);
    }
    if (counted(one, t->left) == 0) {
        return made_up(t, one);
    }
    if (!t->has_clock) {
        return merge(t, one);
    }
    put(t, TWIN_FLAGS, FLAG_OVERFLOW);
    advance(one);
    look_for_clock(t);
    return served(t, one);
}

// .Lnext_entry: the interval that is loaded is right if the train goes on. `loaded`: it.
static enum next entry_ahead(struct twin *t, const struct interval *loaded)
{
    uint8_t tail = t->engine.tail;

    t->last = loaded->low;
    bool goes_on = t->ring->high[tail] == STEP_HIGH_TRAIN &&
                   ((int8_t)t->ring->low[tail] < 0) == loaded->second;
    if (!goes_on) {
        t->engine.left = 0;
        refill(t, loaded->second);
        return AGAIN;
    }
    visit(t, TWIN_ENTRY_AHEAD);
    t->left = take_count(t);
    return over(t) ? merge(t, loaded) : made_up(t, loaded);
}

// make_up_fast behind the write of the counter: load the next interval, `one` from now on, at once.
static enum next load_fast(struct twin *t, struct interval *one)
{
    bool second = one->second;

    *one = interval_of(t, second);
    put(t, TWIN_TOP_LOW, one->low);
    bool is_late = over(t);
    t->left = counted(one, t->left);
    if (t->left != 0) {
        t->engine.left = t->left;
        return is_late ? LATE : made_up(t, one);
    }
    if (!is_late) {
        return entry_ahead(t, one);
    }
    t->engine.left = 0;
    refill(t, second);
    return AGAIN;
}

// .Lfast
static enum next make_up_fast(struct twin *t, struct interval *one)
{
    uint8_t first = (uint8_t)(t->low_ticks + FIRST_AFTER_EDGE);
    int longer = one->is_long ? 1 : -1;

    put(t, TWIN_FLAGS, FLAG_OVERFLOW);
    if (t->engine.train_high != 0) {
        return set_by_a_tick(t, one);
    }
    uint8_t count = get(t, TWIN_COUNT_LOW);
    if (count < first) {
        if (count < SINCE_FAST + clock_look(t)) {
            return FAIL;
        }
        visit(t, TWIN_BEFORE_EDGE);
        while ((count = get(t, TWIN_COUNT_LOW)) < first) {
            if (over(t)) {
                return FAIL;
            }
        }
    }
    uint8_t then = (uint8_t)(count + AHEAD + MARGIN);
    if (then >= one->low) {
        return FAIL;
    }
    visit(t, TWIN_SET_FAST);
    put(t, TWIN_COUNT_LOW, (uint8_t)((int)(count + AHEAD) - longer));
    t->last = one->low;
    advance(one);
    return load_fast(t, one);
}

// make_up, once: LATE if the interval that it has loaded is late as well.
static enum next late_once(struct twin *t, struct interval *one)
{
    if (t->has_clock && (get(t, TWIN_FLAGS) & FLAG_CAPTURE) != 0) {
        return rarely(t, one);
    }
    if (t->last == 0) {
        return rarely(t, one);
    }
    if (t->last == one->low) {
        return made_up_equal(t, one);
    }
    if ((uint8_t)(t->last + (one->is_long ? 1 : -1)) != one->low) {
        return rarely(t, one);
    }
    if (one->low < LONG_LOW) {
        return make_up_fast(t, one);
    }
    if (counted(one, t->left) == 0) {
        return rarely(t, one);
    }
    put(t, TWIN_FLAGS, FLAG_OVERFLOW);
    return set_by_a_tick(t, one);
}

// make_up: the interval is loaded, and the next period had begun before.
static enum next late(struct twin *t, struct interval *one)
{
    enum next next = LATE;

    while (next == LATE) {
        next = late_once(t, one);
    }
    return next;
}

// train_interval
static enum next train_period(struct twin *t, bool second)
{
    struct interval one = interval_of(t, second);

    put(t, TWIN_TOP_LOW, one.low);
    return over(t) ? late(t, &one) : made_up(t, &one);
}

// .Lcatch_up_entry: a single period, behind a train's whose intervals have the high byte 0.
static bool catch_up_entry(struct twin *t, uint16_t top)
{
    uint8_t before = t->ring->high[(uint8_t)(t->engine.tail - 1u)];

    if (before != STEP_HIGH_TRAIN || t->engine.train_high != 0 || t->last == 0 ||
        top < t->last + STRETCH_MIN) {
        return false;
    }
    visit(t, TWIN_STRETCH_ENTRY);
    return stretch(t, (uint16_t)(top - t->last), (uint8_t)top);
}

static enum next single(struct twin *t, uint8_t high)
{
    uint8_t low = t->ring->low[t->engine.tail];

    put(t, TWIN_TOP_HIGH, high);
    put(t, TWIN_TOP_LOW, low);
    if (over(t) && !catch_up_entry(t, (uint16_t)(high << 8 | low))) {
        return FAIL;
    }
    t->engine.tail = (uint8_t)(t->engine.tail + 1u);
    return LEAVE;
}

// .Lrare of a train: take_train
static enum next begin_train(struct twin *t)
{
    bool second = take_count(t) < 0;
    uint8_t high = t->engine.trains[second].top_high;

    t->engine.train_high = high;
    put(t, TWIN_TOP_HIGH, high);
    t->last = 0;
    t->before_high = UNKNOWN;
    return AGAIN;
}

// .Lhalt
static enum next halt(struct twin *t)
{
    put(t, TWIN_EDGE_HIGH, QUIET);
    put(t, TWIN_EDGE_LOW, QUIET);
    put(t, TWIN_TOP_HIGH, (uint8_t)((STEP_IDLE_TICKS - 1u) >> 8));
    put(t, TWIN_TOP_LOW, (uint8_t)((STEP_IDLE_TICKS - 1u) & 0xFFu));
    if (over(t)) {
        return FAIL;
    }
    t->engine.state = STEP_ENGINE_HALTED;
    t->engine.pulse = false;
    t->engine.idle_count = (uint16_t)(t->engine.idle_count + 1u);
    put(t, TWIN_FLAGS, FLAG_COMPARE);
    put(t, TWIN_MASK, (uint8_t)((get(t, TWIN_MASK) & ~MASK_OVERFLOW) | MASK_COMPARE));
    return LEAVE;
}

// .Lcommand
static enum next command(struct twin *t, uint8_t high)
{
    if (high == STEP_HIGH_COMMAND) {
        (void)get(t, TWIN_MASK);
        put(t, TWIN_MASK, 0);
        t->end = TWIN_COMMAND;
        return LEAVE;
    }
    if (t->engine.state == STEP_ENGINE_IN_LINE) {
        return halt(t);
    }
    t->engine.idle_count = (uint16_t)(t->engine.idle_count + 1u);
    return over(t) ? FAIL : LEAVE;
}

static enum next entry(struct twin *t)
{
    uint8_t high = t->ring->high[t->engine.tail];

    if (high < STEP_HIGH_TRAIN) {
        return single(t, high);
    }
    return high == STEP_HIGH_TRAIN ? begin_train(t) : command(t, high);
}

enum twin_end twin_interrupt(struct twin *t)
{
    enum next next = AGAIN;

    t->end = TWIN_RETURNS;
    t->visited = 0;
    while (next == AGAIN || next == PERIOD) {
        t->left = t->engine.left;
        next = t->left == 0 ? entry(t) : train_period(t, t->left < 0);
    }
    if (next == FAIL) {
        put(t, TWIN_CONTROL, CONTROL_NO_PIN);
        t->end = TWIN_LATE;
    }
    return t->end;
}
