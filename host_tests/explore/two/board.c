// SPDX-License-Identifier: MIT
#include "explore/board.h"

#include <avr/io.h>
#include <stddef.h>

#include "app/axes/limits.h"
#include "app/axes/reference.h"
#include "app/board.h"
#include "app/round.h"
#include "app/settings/settings.h"
#include "app/watch/safety.h"
#include "app/watch/time_check.h"
#include "avr/hal/capture_queue.h"
#include "explore/judge.h"
#include "explore/part.h"
#include "explore/two/board.h"
#include "explore/two/scene.h"
#include "hal/estop.h"
#include "hal/pins.h"
#include "hal/step_timer.h" // step_timer_heartbeat
#include "wire/bytes.h"
#include "wire/register_map.h"
#include "wire/server_data.h"

#define PASS_MAX    400u // most timed events until an awaited one has come
#define TRIES       4u   // most attempts to clear a fault
#define EDGES_AHEAD 5u   // of the edge that `go` names

// Pixels of the lines.
static const struct segment pixels_22[] = {{17, 1}, {3, 1}, {1, 1}, {-1, 1}};
static const struct segment pixels_24[] = {{19, 1}, {-2, 1}, {2, 1}, {-1, 1}};
static const struct segment pixels_50[] = {{24, 1}, {24, 1}, {2, 1}};
static const struct segment pixels_2[] = {{2, 1}};

#define PLAN(pixels, steps) {(pixels), sizeof(pixels) / sizeof(pixels)[0], (steps)}
static const struct line_plan plans[] = {
    [LINE_NONE] = {NULL, 0, 0},
    [LINE_OF_22] = PLAN(pixels_22, 22),
    [LINE_OF_24] = PLAN(pixels_24, 24),
    [LINE_OF_50] = PLAN(pixels_50, 50),
    [LINE_OF_2] = PLAN(pixels_2, 2),
};

const struct line_plan *scene_plan(uint8_t line)
{
    return &plans[line];
}

void scene_sync(uint16_t sync)
{
    settings_record()->sync = sync;
    limits_apply_settings();
    if (sync != SYNC_FREE) {
        part_start_clock(PIXEL_TICKS);
    }
}

void board_power_on(void)
{
    part_power_on();
    part_share(step_engines, sizeof step_engines);
    part_share(step_rings, sizeof step_rings);
    part_share(&pixel_clock_edges, sizeof pixel_clock_edges);
    pins_start();
    board_start();
    settings_record()->enable_settle_ms = 0;
    settings_record()->bus_timeout_ms = 0;
    settings_record()->pixel_hz_num[1] = PIXEL_HZ;
    scene_sync(SYNC_FREE);
    time_check_start();
    part_sei();
    safety_start();
}

void board_round(void)
{
    round_poll();
}

void board_idle(void)
{
    part.points = 0;
    part_point();
    part_happen(PART_PERIOD_ENDS);
    part_point();
    board_round();
    part_point();
    judge_between();
}

static bool order(uint16_t command, uint16_t mask, uint16_t argument, uint16_t edge)
{
    uint8_t words[8];

    put_word(&words[0], mask);
    put_word(&words[2], command);
    put_word(&words[4], argument);
    put_word(&words[6], edge);
    return data_write(REG_HOLDING_axis_mask, 4, words) == MODBUS_OK;
}

bool scene_order(uint16_t command, uint16_t mask, uint16_t argument)
{
    bool done = order(command, mask, argument, 0);

    if (done && (command == COMMAND_STOP || command == COMMAND_DISARM ||
                 command == COMMAND_DISCARD)) {
        judge_ended((uint8_t)mask);
    }
    return done;
}

bool scene_arm(uint16_t mask, uint16_t token)
{
    struct judged was = judged;

    // The line may begin before the order has been answered.
    judge_armed((uint8_t)mask, token != 0);
    if (order(COMMAND_ARM, mask, token, 0)) {
        return true;
    }
    judged = was;
    return false;
}

bool scene_go(uint16_t token)
{
    struct judged was = judged;
    uint16_t edge = (uint16_t)(reference_number() + EDGES_AHEAD);

    if (token == SCENE_TOKEN) {
        judge_went();
    }
    if (order(COMMAND_GO, 1, token, edge)) {
        return true;
    }
    judged = was;
    return false;
}

static bool write_block(uint8_t axis, const struct segment *entries, uint8_t count)
{
    uint8_t words[4 + 4 * 8];

    put_word(&words[0], axes_get(axis)->next_block);
    put_word(&words[2], axis);
    for (uint8_t i = 0; i < count; i++) {
        put_word(&words[4u + 4u * i], (uint16_t)entries[i].count);
        put_word(&words[6u + 4u * i], entries[i].repeat);
    }
    return data_write(REG_QUEUE_WINDOW, (uint16_t)(2u + 2u * count), words) == MODBUS_OK;
}

bool scene_line(uint8_t axis, enum line_kind line, uint16_t flags)
{
    const struct line_plan *plan = scene_plan(line);
    struct segment entries[8] = {{(int16_t)(LINE_MARK_START | flags), 0}, {0, 0}};
    uint8_t count = 2;

    for (uint8_t i = 0; i < plan->count; i++) {
        entries[count++] = plan->pixels[i];
    }
    entries[count++] = (struct segment){LINE_MARK_END, 0};
    struct judged was = judged;

    judge_queued(axis, line, (flags & LINE_START_WAIT) != 0);
    if (write_block(axis, entries, count)) {
        return true;
    }
    judged = was;
    return false;
}

bool scene_refused_block(uint8_t axis)
{
    const struct segment none = {0x0FFF, 0};

    return write_block(axis, &none, 1);
}

void scene_press(bool pressed)
{
    if (part_estop_pressed() != pressed) {
        part_happen(PART_PIN_CHANGES);
    }
}

bool scene_pass_until(bool (*there)(void))
{
    for (uint16_t i = 0; i < PASS_MAX; i++) {
        if (there()) {
            return true;
        }
        board_idle();
    }
    return false;
}

static uint8_t state_of(uint8_t axis)
{
    return axes_get(axis)->life.state;
}

bool two_held(uint8_t axis)
{
    return lifecycle_armed(&axes_get(axis)->life) || state_of(axis) == AXIS_LOADED;
}

bool two_moving(uint8_t axis)
{
    return lifecycle_moving(&axes_get(axis)->life);
}

bool two_finished(uint8_t axis)
{
    return state_of(axis) == AXIS_DONE;
}

bool two_loaded(uint8_t axis)
{
    return state_of(axis) == AXIS_LOADED;
}

bool two_empty(uint8_t axis)
{
    return state_of(axis) == AXIS_EMPTY;
}

bool two_halted(uint8_t axis)
{
    uint8_t state = step_engines[axis].state;

    return state == STEP_ENGINE_HALTED || state == STEP_ENGINE_HALTING;
}

bool two_rests(uint8_t axis)
{
    uint8_t state = state_of(axis);

    return !two_moving(axis) && state != AXIS_STOPPING &&
           !step_engine_going((enum step_engine_state)step_engines[axis].state);
}

bool board_stopped(void)
{
    bool deaf = *part_reception_off;

    *part_reception_off = true;
    bool stopped = faults_record()->code != FAULT_none || estop_latched();
    *part_reception_off = deaf;
    return stopped;
}

bool board_promise_broken(void)
{
    return (faults_record()->mask & (1uL << FAULT_internal | 1uL << FAULT_stray_steps)) !=
           0;
}

bool board_estop_recorded(void)
{
    return (faults_record()->mask & 1uL << FAULT_estop) != 0;
}

static bool is_within(const volatile void *address, const volatile void *of, size_t bytes)
{
    return (uintptr_t)address - (uintptr_t)of < bytes;
}

// The accesses of a function lie so close behind its address.
#define FUNCTION_BYTES 128u

static bool is_heartbeat(const void *pc)
{
    return (uintptr_t)pc - (uintptr_t)&step_timer_heartbeat < FUNCTION_BYTES;
}

// Words that a protocol keeps apart: the trains that no entry of the ring refers to; what a
// captured edge is noted in, before `head` says so and behind it (the handler writes bytes); the
// count of idle periods while no interrupt serves the axis. The heartbeat is the low byte of that
// count.
static bool is_excused(uint8_t axis, const struct part_access *access)
{
    struct step_engine *engine = &step_engines[axis];
    bool served = (part_registers.timers[axis].timsk & (_BV(TOIE1) | _BV(OCIE1A))) != 0;

    if (access->address == &engine->idle_count) {
        return !served || is_heartbeat(access->pc);
    }
    return is_within(access->address, engine->trains, sizeof engine->trains);
}

bool board_excused(const struct part_access *access)
{
    bool excused =
        is_within(access->address, &pixel_clock_edges, sizeof pixel_clock_edges);

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        excused = excused || is_excused(i, access);
    }
    return excused;
}

int32_t two_position(uint8_t axis)
{
    uint16_t address = (uint16_t)(REG_AXIS_BASE + axis * REG_AXIS_STRIDE + 6u);

    *part_reception_off = true;
    uint32_t position =
        (uint32_t)data_input(address) << 16 | data_input((uint16_t)(address + 1u));
    *part_reception_off = false;
    return (int32_t)position;
}

// Clear the fault. The board refuses while a step is still to come.
static bool clears(void)
{
    for (uint8_t i = 0; i < TRIES; i++) {
        if (scene_order(COMMAND_CLEAR_FAULT, 1, 0)) {
            return true;
        }
        board_idle();
    }
    return false;
}

static bool both_empty(void)
{
    return two_empty(0) && two_empty(1);
}

static bool both_finished(void)
{
    return two_finished(0) && two_finished(1);
}

bool board_recovers(void)
{
    scene_press(false);
    board_idle();
    board_idle();
    if (!clears() || !scene_order(COMMAND_DISCARD, BOTH, 0) ||
        !scene_pass_until(both_empty)) {
        return false;
    }
    board_idle();
    int32_t from[CONFIG_AXES];

    judged.may_fault = false;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        from[i] = judged.axes[i].position;
        if (!scene_line(i, LINE_OF_2, 0)) {
            return false;
        }
    }
    if (!scene_arm(BOTH, 0) || !scene_pass_until(both_finished)) {
        return false;
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (judged.axes[i].position != from[i] + 2 ||
            two_position(i) != judged.axes[i].position) {
            return false;
        }
    }
    judged.permit_given = true;
    return scene_order(COMMAND_PERMIT_ON, 1, 0) && part_permit_high();
}

static void describe_axis(FILE *report, uint8_t i)
{
    const struct step_engine *engine = &step_engines[i];
    const struct judged_axis *axis = &judged.axes[i];
    const struct part_timer *timer = &part.timers[i];

    (void)fprintf(report,
                  "  axis %u: state %u; engine state %u, tail %u, left %d, cut %d; "
                  "position %ld\n",
                  i,
                  state_of(i),
                  engine->state,
                  engine->tail,
                  engine->left,
                  engine->cut,
                  (long)two_position(i));
    (void)fprintf(report,
                  "    edges made %ld, of the line %u, line zero %lu; period from %lu, "
                  "%u and then %u; TIMSK %02X, TIFR %02X\n",
                  (long)axis->position,
                  axis->made,
                  (unsigned long)axis->zero_ticks,
                  (unsigned long)timer->began_ticks,
                  timer->top,
                  timer->buffer_top,
                  part_registers.timers[i].timsk,
                  part_registers.timers[i].tifr);
}

void board_describe(FILE *report)
{
    (void)fprintf(report,
                  "  tick %lu, fault %u, the clock's next edge %lu\n",
                  (unsigned long)part.now_ticks,
                  faults_record()->code,
                  (unsigned long)part.clock_ticks);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        describe_axis(report, i);
    }
}
