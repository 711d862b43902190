// SPDX-License-Identifier: MIT
#include "explore/judge.h"

#include "explore/board.h"
#include "explore/part.h"
#include "explore/two/board.h"
#include "explore/two/judged.h"
#include "explore/two/scene.h"

#define EVENTS_AT_REST 6u   // timed events without an edge
#define REST_MAX       600u // timed events until the axes rest
#define DELAY_TICKS    3u   // from an edge of the clock to its capture

struct judged judged;

static struct judged_axis *of(uint8_t axis)
{
    return &judged.axes[axis];
}

static void allow_at_most(uint8_t axis, uint8_t edges)
{
    if (of(axis)->edges_allowed > edges) {
        of(axis)->edges_allowed = edges;
    }
}

static const struct judged_line no_line = {LINE_NONE, false};

static bool has_line(const struct judged_axis *axis, uint8_t number)
{
    return axis->lines[number].kind != LINE_NONE;
}

// Of the line that is being made.
static const struct line_plan *plan_of(const struct judged_axis *axis)
{
    return scene_plan(axis->lines[0].kind);
}

static void forget_lines(uint8_t axis)
{
    for (uint8_t i = 0; i < JUDGE_LINES; i++) {
        of(axis)->lines[i] = no_line;
    }
    of(axis)->must_finish = false;
}

void judge_queued(uint8_t axis, enum line_kind line, bool clocked)
{
    uint8_t i = 0;

    while (i < JUDGE_LINES - 1u && has_line(of(axis), i)) {
        i++;
    }
    of(axis)->lines[i] = (struct judged_line){(uint8_t)line, clocked};
}

void judge_armed(uint8_t mask, bool by_token)
{
    judged.arms++;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if ((mask & axis_bit(i)) != 0) {
            of(i)->zero_known = false;
            of(i)->made = 0;
            of(i)->arm_number = judged.arms;
            of(i)->edges_allowed = JUDGE_ANY_NUMBER;
            of(i)->must_finish = true;
            of(i)->waits = by_token;
        }
    }
}

void judge_went(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        of(i)->waits = false;
    }
}

void judge_ended(uint8_t mask)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if ((mask & axis_bit(i)) != 0) {
            of(i)->must_finish = false;
            of(i)->waits = false;
        }
    }
}

// Pixel and step of an edge of a line; step 1 is the first one.
struct place {
    uint8_t pixel, step;
    int16_t of_steps;
};

static struct place place_of(const struct line_plan *plan, uint8_t made)
{
    struct place place = {0, (uint8_t)(made + 1u), 0};

    for (;;) {
        int16_t count = plan->pixels[place.pixel].count;
        uint8_t steps = (uint8_t)(count < 0 ? -count : count);
        if (place.step <= steps) {
            place.of_steps = count;
            return place;
        }
        place.step = (uint8_t)(place.step - steps);
        place.pixel++;
    }
}

// Step j of n in a pixel of T ticks falls at ceil(j * T / n).
static uint32_t ticks_of(const struct place *place)
{
    uint32_t steps = (uint32_t)(place->of_steps < 0 ? -place->of_steps : place->of_steps);

    return place->pixel * PIXEL_TICKS + (place->step * PIXEL_TICKS + steps - 1u) / steps;
}

// The first line is made; the next one goes on where the first one ended.
static void begin_next_line(struct judged_axis *axis)
{
    axis->zero_ticks += plan_of(axis)->count * PIXEL_TICKS;
    axis->made = 0;
    for (uint8_t i = 1; i < JUDGE_LINES; i++) {
        axis->lines[i - 1u] = axis->lines[i];
    }
    axis->lines[JUDGE_LINES - 1u] = no_line;
}

// A line that follows the clock begins on an edge of it, and with it all that were armed together.
static void judge_zero(uint8_t number)
{
    const struct judged_axis *axis = of(number);

    if (!axis->lines[0].clocked) {
        return;
    }
    uint32_t edge_ticks = part.clock_ticks - DELAY_TICKS;
    if ((edge_ticks - axis->zero_ticks) % part.clock_every != 0) {
        judge_broken(JUDGE_TICK);
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        const struct judged_axis *other = of(i);
        if (other->arm_number == axis->arm_number && other->lines[0].clocked &&
            other->zero_known && other->zero_ticks != axis->zero_ticks) {
            judge_broken(JUDGE_TOGETHER);
        }
    }
}

static void judge_place(uint8_t number, uint32_t ticks, bool negative)
{
    struct judged_axis *axis = of(number);

    if (has_line(axis, 0) && axis->made == plan_of(axis)->steps) {
        begin_next_line(axis);
    }
    if (!has_line(axis, 0)) {
        judge_broken(JUDGE_RUNAWAY);
    }
    struct place place = place_of(plan_of(axis), axis->made);

    if (negative != (place.of_steps < 0)) {
        judge_broken(JUDGE_DIRECTION);
    }
    if (!axis->zero_known) {
        axis->zero_ticks = ticks - ticks_of(&place);
        judge_zero(number);
        axis->zero_known = true;
    }
    if (ticks != axis->zero_ticks + ticks_of(&place)) {
        judge_broken(JUDGE_TICK);
    }
    axis->made++;
}

void judge_edge(uint8_t axis, uint32_t ticks, bool negative)
{
    of(axis)->position += negative ? -1 : 1;
    if (of(axis)->edges_allowed == 0) {
        judge_broken(JUDGE_RUNAWAY);
    }
    if (of(axis)->edges_allowed != JUDGE_ANY_NUMBER) {
        of(axis)->edges_allowed--;
    } else if (two_held(axis) || of(axis)->waits) {
        judge_broken(JUDGE_EARLY);
    }
    judge_place(axis, ticks, negative);
}

// A fault ends all that moves. Only the emergency stop, an order that asks for it, or a host that
// falls silent may bring one.
static void judge_faults(void)
{
    judged.may_fault = judged.may_fault || part_estop_pressed();
    if (!board_stopped()) {
        return;
    }
    judged.permit_given = false;
    if (!judged.may_fault) {
        judge_broken(JUDGE_FAULT);
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        of(i)->must_finish = false;
        of(i)->waits = false;
    }
}

void judge_look(void)
{
    judge_faults();
    // After a halt the timer still makes the step that it holds already.
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (two_halted(i)) {
            allow_at_most(i, 1);
        }
    }
    if (part_permit_high() && !judged.permit_given) {
        judge_broken(JUDGE_PERMIT);
    }
}

void judge_access(const struct part_access *access)
{
    if (access->bytes > 1 && part.interrupts_on && !board_excused(access)) {
        judge_broken(JUDGE_WIDE);
    }
}

static void judge_made(uint8_t number)
{
    const struct judged_axis *axis = of(number);

    if (axis->must_finish && axis->made != plan_of(axis)->steps) {
        judge_broken(JUDGE_UNFINISHED);
    }
    allow_at_most(number, 0);
}

// The axis says that it has made all its lines.
static void judge_done(uint8_t number)
{
    judge_made(number);
    if (of(number)->must_finish && has_line(of(number), 1)) {
        judge_broken(JUDGE_UNFINISHED);
    }
    forget_lines(number);
}

// The axis waits to be armed: its last line was decoded as a whole before the next one came, which
// does not follow by itself then.
static void judge_loaded(uint8_t number)
{
    if (of(number)->must_finish) {
        judge_made(number);
        begin_next_line(of(number));
        of(number)->must_finish = false;
    }
}

void judge_between(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (two_finished(i)) {
            judge_done(i);
        } else if (two_loaded(i)) {
            judge_loaded(i);
            allow_at_most(i, 1);
        } else if (!two_moving(i) || board_stopped()) {
            allow_at_most(i, 1);
        }
        if (two_empty(i)) {
            forget_lines(i);
        }
    }
    if (board_promise_broken()) {
        judge_broken(JUDGE_PROMISE);
    }
}

static bool rests(uint8_t axis)
{
    return two_rests(axis) || (two_held(axis) && of(axis)->waits);
}

// Bring both axes to rest: each waits for its token, or does nothing any more.
static void come_to_rest(void)
{
    uint32_t quiet = 0;

    for (uint32_t i = 0; quiet < EVENTS_AT_REST; i++) {
        int32_t sum = of(0)->position + 1000 * of(1)->position;
        if (i == REST_MAX) {
            judge_broken(JUDGE_HANGS);
        }
        board_idle();
        bool same = sum == of(0)->position + 1000 * of(1)->position;
        quiet = same && rests(0) && rests(1) ? quiet + 1u : 0;
    }
}

void judge_rest(void)
{
    come_to_rest();
    if (part_estop_pressed() && !board_estop_recorded()) {
        judge_broken(JUDGE_ESTOP);
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (two_position(i) != of(i)->position) {
            judge_broken(JUDGE_POSITION);
        }
        // What nothing has ended is done by now, unless it waits for its token.
        if (of(i)->must_finish && !of(i)->waits) {
            judge_broken(JUDGE_UNFINISHED);
        }
    }
    if (!board_recovers()) {
        judge_broken(JUDGE_STUCK);
    }
}
