// SPDX-License-Identifier: MIT
#include "explore/board.h"

#include <avr/io.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "app/machine.h"
#include "app/round.h"
#include "app/safety.h"
#include "app/serial.h"
#include "app/time_check.h"
#include "explore/judge.h"
#include "explore/part.h"
#include "explore/program.h"
#include "hal/clock.h"
#include "hal/cpu.h"
#include "hal/eeprom.h"
#include "hal/estop.h"
#include "hal/pins.h"
#include "hal/step_timer.h"
#include "hal/switches.h"
#include "wire/bytes.h"
#include "wire/register_map.h"
#include "wire/server.h"

#define TOKEN       7u
#define OTHER_TOKEN 8u
#define PREPARE_MAX 200u // periods until a scenario has come
#define TRIES       4u   // to clear a fault
#define UNITS_OF_MS 256u // of 4 us, nearly

extern struct step_engine step_engines[CONFIG_AXES];
extern struct step_ring step_rings[CONFIG_AXES];

static uint32_t now_4us;

// Contracts of the hal that nothing here depends on.
uint32_t clock_now_4us(void)
{
    return now_4us;
}

uint8_t cpu_reset_cause(void)
{
    return 1;
}

void cpu_watchdog_start(void)
{
}

void cpu_watchdog_feed(void)
{
}

bool cpu_stack_intact(void)
{
    return true;
}

void cpu_section(enum cpu_section section)
{
    (void)section;
}

bool eeprom_busy(void)
{
    return false;
}

uint8_t eeprom_read(uint16_t address)
{
    (void)address;
    return 0xFF;
}

void eeprom_write(uint16_t address, uint8_t byte)
{
    (void)address;
    (void)byte;
}

uint8_t switches_read(uint8_t axis)
{
    (void)axis;
    return SWITCH_ALL;
}

void switch_capture_start(uint8_t axis, bool to_high)
{
    (void)axis;
    (void)to_high;
}

void switch_capture_stop(void)
{
}

bool switch_capture_waiting(void)
{
    return false;
}

bool switch_capture_take(struct switch_capture *capture)
{
    (void)capture;
    return false;
}

uint16_t serial_last_request_ms(void)
{
    return clock_now_ms();
}

const struct server_counters *serial_counters(void)
{
    static const struct server_counters none;

    return &none;
}

static struct axis *axis(void)
{
    return &machine.axes[0];
}

static enum modbus_exception give_order(uint16_t command, uint16_t argument)
{
    uint8_t words[6];

    put_word(&words[0], 1);
    put_word(&words[2], command);
    put_word(&words[4], argument);
    return data_write(REG_HOLDING_axis_mask, 3, words);
}

static enum modbus_exception give_block(const struct run *runs, uint8_t count)
{
    uint8_t words[4 + 4 * 32];

    put_word(&words[0], axis()->next_block);
    put_word(&words[2], 0);
    for (uint8_t i = 0; i < count; i++) {
        put_word(&words[4u + 4u * i], (uint16_t)runs[i].count);
        put_word(&words[6u + 4u * i], runs[i].repeat);
    }
    return data_write(REG_QUEUE_WINDOW, (uint16_t)(2u + 2u * count), words);
}

#define BLOCK(...)                                                                       \
    give_block((const struct run[]){__VA_ARGS__},                                        \
               (uint8_t)(sizeof((const struct run[]){__VA_ARGS__}) / sizeof(struct run)))
#define START(flags) {(int16_t)(RUN_MARK_START | (flags)), 0}, {0, 0}
#define END          {RUN_MARK_END, 0}

// Single periods, a run, intervals of several periods, a reversal.
#define LINE(flags) BLOCK(START(flags), {3, 1}, {17, 1}, {1, 1}, {-1, 1}, END)

static void set_pixel_hz(uint16_t hz)
{
    machine.settings.pixel_hz_num[1] = hz;
    machine_apply_settings();
}

// Everything that a refused order must leave as it was.
struct observed {
    struct machine machine;
    struct step_engine engine;
    struct step_ring ring;
    uint16_t top, edge;
    bool permit;
};

// Allocated before the first state is saved: what was observed is not part of a state.
static struct observed *observed;

void board_power_on(void)
{
    observed = allocate(NULL, 2u * sizeof *observed);
    part_deaf = allocate(NULL, sizeof *part_deaf);
    *part_deaf = false;
    part_power_on();
    part_share(step_engines, sizeof step_engines);
    part_share(step_rings, sizeof step_rings);
    pins_start();
    machine_init();
    machine.settings.enable_settle_ms = 0;
    set_pixel_hz(100);
    time_check_start();
    part_sei();
    safety_start();
}

void board_round(void)
{
    now_4us += UNITS_OF_MS;
    round_poll();
}

void board_idle(void)
{
    part_point();
    if (part_possible(PART_PERIOD_ENDS)) {
        part_happen(PART_PERIOD_ENDS);
    }
    part_point();
    board_round();
    part_point();
    judge_between();
}

// Scenarios.

static bool pass_until(bool (*there)(void))
{
    for (uint16_t i = 0; i < PREPARE_MAX; i++) {
        if (there()) {
            return true;
        }
        board_idle();
    }
    return false;
}

static const struct step_engine *engine(void)
{
    return &step_engines[0];
}

static bool running(void)
{
    return axis()->state == AXIS_RUNNING;
}

static bool in_delay(void)
{
    return running() && engine()->state == STEP_ENGINE_IN_LINE;
}

static bool in_singles(void)
{
    return in_delay() && engine()->pulse && engine()->left == 0;
}

static bool in_run(void)
{
    return in_delay() && engine()->left > 1;
}

static bool near_end_of_run(void)
{
    return in_delay() && engine()->left == 1;
}

// Behind the run: the step is made, its interval goes on.
static bool in_long_interval(void)
{
    return in_delay() && judged.position >= 19 && !engine()->pulse;
}

static bool reverses(void)
{
    return in_delay() && engine()->negative;
}

static bool line_ended(void)
{
    return running() && engine()->state == STEP_ENGINE_IDLE && !axis()->in_line &&
           axis()->feed.head == engine()->tail;
}

static bool before_end(void)
{
    return in_delay() && !axis()->in_line &&
           (uint8_t)(axis()->feed.head - engine()->tail) == 1;
}

static bool starving(void)
{
    return in_delay() && axis()->dry && axis()->feed.head == engine()->tail;
}

static bool failed(void)
{
    return axis()->state == AXIS_FAULT;
}

static bool finished(void)
{
    return axis()->state == AXIS_DONE;
}

static bool arm(uint16_t token)
{
    judged.edges_allowed = JUDGE_ANY_NUMBER;
    return give_order(COMMAND_ARM, token) == MODBUS_OK;
}

static bool load_and_arm(void)
{
    return LINE(0) == MODBUS_OK && arm(0);
}

static bool prepare_empty(void)
{
    return true;
}

static bool prepare_loaded(void)
{
    return LINE(0) == MODBUS_OK;
}

static bool prepare_held(void)
{
    return LINE(RUN_START_WAIT) == MODBUS_OK && arm(0);
}

static bool prepare_held_by_token(void)
{
    return LINE(0) == MODBUS_OK && arm(TOKEN);
}

static bool prepare_armed(void)
{
    return load_and_arm();
}

static bool prepare_delay(void)
{
    return load_and_arm() && pass_until(running);
}

static bool prepare_singles(void)
{
    return load_and_arm() && pass_until(in_singles);
}

static bool prepare_run(void)
{
    return load_and_arm() && pass_until(in_run);
}

static bool prepare_end_of_run(void)
{
    return load_and_arm() && pass_until(near_end_of_run);
}

static bool prepare_long_interval(void)
{
    return load_and_arm() && pass_until(in_long_interval);
}

static bool prepare_reversal(void)
{
    return load_and_arm() && pass_until(reverses);
}

static bool prepare_before_end(void)
{
    return load_and_arm() && pass_until(before_end);
}

static bool prepare_ended(void)
{
    return load_and_arm() && pass_until(line_ended);
}

static bool prepare_done(void)
{
    return load_and_arm() && pass_until(finished);
}

// Streamed, and the host falls silent.
static bool load_open_line(void)
{
    bool taken = BLOCK(START(0), {1, 1}, {2, 1}) == MODBUS_OK;

    for (uint8_t i = 0; i < 12; i++) {
        taken = taken && BLOCK({1, 1}, {2, 1}) == MODBUS_OK;
    }
    return taken && arm(0);
}

static bool prepare_starving(void)
{
    return load_open_line() && pass_until(starving);
}

static bool prepare_starved(void)
{
    return load_open_line() && pass_until(failed);
}

static bool prepare_stopping(void)
{
    bool stopped = prepare_run() && give_order(COMMAND_STOP, 0) == MODBUS_OK;

    judge_between();
    return stopped;
}

static bool prepare_estop(void)
{
    bool there = prepare_singles();

    part_happen(PART_PIN_CHANGES);
    return there && pass_until(failed);
}

// Intervals short enough for an interrupt that comes too late.
static bool load_fast(void)
{
    set_pixel_hz(1500);
    return BLOCK(START(0), {12, 1}, {40, 1}, {12, 1}, END) == MODBUS_OK && arm(0);
}

static bool prepare_fast_singles(void)
{
    return load_fast() && pass_until(in_singles);
}

static bool prepare_fast_run(void)
{
    return load_fast() && pass_until(in_run);
}

struct scenario {
    const char *name;
    bool (*prepare)(void);
};

static const struct scenario scenarios[] = {
    {"empty", prepare_empty},
    {"loaded", prepare_loaded},
    {"armed, about to be released", prepare_armed},
    {"armed, waits for the pixel clock", prepare_held},
    {"armed, waits for its token", prepare_held_by_token},
    {"released, before its delay", prepare_delay},
    {"single periods", prepare_singles},
    {"inside a run", prepare_run},
    {"last period of a run", prepare_end_of_run},
    {"inside a long interval", prepare_long_interval},
    {"behind a reversal", prepare_reversal},
    {"before the end command", prepare_before_end},
    {"behind the end command", prepare_ended},
    {"done", prepare_done},
    {"about to starve", prepare_starving},
    {"starved", prepare_starved},
    {"stopping", prepare_stopping},
    {"emergency stop", prepare_estop},
    {"short single periods", prepare_fast_singles},
    {"inside a fast run", prepare_fast_run},
};

uint8_t board_scenarios(void)
{
    return sizeof scenarios / sizeof scenarios[0];
}

const char *board_scenario(uint8_t scenario)
{
    return scenarios[scenario].name;
}

bool board_prepare(uint8_t scenario)
{
    return scenarios[scenario].prepare();
}

// Actions.

enum kind { KIND_ORDER, KIND_GOOD_BLOCK, KIND_REFUSED_BLOCK, KIND_PRESS, KIND_RELEASE, KIND_NOTHING };

struct action {
    const char *name;
    uint8_t kind;
    uint8_t command;
    uint8_t argument;
};

static const struct action actions[] = {
    {"nothing", KIND_NOTHING, 0, 0},
    {"arm", KIND_ORDER, COMMAND_ARM, 0},
    {"arm with a token", KIND_ORDER, COMMAND_ARM, TOKEN},
    {"go", KIND_ORDER, COMMAND_GO, TOKEN},
    {"go with another token", KIND_ORDER, COMMAND_GO, OTHER_TOKEN},
    {"disarm", KIND_ORDER, COMMAND_DISARM, 0},
    {"stop", KIND_ORDER, COMMAND_STOP, 0},
    {"discard", KIND_ORDER, COMMAND_DISCARD, 0},
    {"clear fault", KIND_ORDER, COMMAND_CLEAR_FAULT, 0},
    {"enable", KIND_ORDER, COMMAND_ENABLE, 0},
    {"disable", KIND_ORDER, COMMAND_DISABLE, 0},
    {"zero", KIND_ORDER, COMMAND_ZERO, 0},
    {"permit on", KIND_ORDER, COMMAND_PERMIT_ON, 0},
    {"permit off", KIND_ORDER, COMMAND_PERMIT_OFF, 0},
    {"a block", KIND_GOOD_BLOCK, 0, 0},
    {"a block that is refused", KIND_REFUSED_BLOCK, 0, 0},
    {"press the emergency stop", KIND_PRESS, 0, 0},
    {"release the emergency stop", KIND_RELEASE, 0, 0},
};

uint8_t board_actions(void)
{
    return sizeof actions / sizeof actions[0];
}

const char *board_action(uint8_t action)
{
    return actions[action].name;
}

static void observe(struct observed *seen)
{
    memset(seen, 0, sizeof *seen);
    memcpy(&seen->machine, &machine, sizeof machine);
    memcpy(&seen->engine, &step_engines[0], sizeof seen->engine);
    memcpy(&seen->ring, &step_rings[0], sizeof seen->ring);
    seen->top = part.buffer_top;
    seen->edge = part.buffer_edge;
    seen->permit = part_permit_high();
}


static void check_refusal(void)
{
    observe(&observed[1]);
    if (!program_task()->disturbed && memcmp(&observed[0], &observed[1], sizeof *observed) != 0) {
        judge_broken(JUDGE_REFUSED);
    }
}

static void order(const struct action *action)
{
    struct judged was = judged;
    bool arms = action->command == COMMAND_ARM;

    if (arms) {
        judged.edges_allowed = JUDGE_ANY_NUMBER;
    }
    if (action->command == COMMAND_PERMIT_ON && !board_stopped()) {
        judged.permit_given = true;
    }
    observe(&observed[0]);
    if (give_order(action->command, action->argument) == MODBUS_OK) {
        if (action->command == COMMAND_STOP || action->command == COMMAND_PERMIT_OFF) {
            judged.permit_given = false;
        }
        return;
    }
    if (arms && judged.edges_allowed > was.edges_allowed) {
        judged.edges_allowed = was.edges_allowed;
    }
    judged.permit_given = judged.permit_given && was.permit_given;
    check_refusal();
}

static void press(bool pressed)
{
    if (part_estop_pressed() != pressed) {
        part_happen(PART_PIN_CHANGES);
    }
}

void board_act(uint8_t number)
{
    const struct action *action = &actions[number];

    switch (action->kind) {
    case KIND_ORDER:
        order(action);
        break;
    case KIND_GOOD_BLOCK:
        (void)BLOCK(START(0), {2, 1}, END);
        break;
    case KIND_REFUSED_BLOCK:
        (void)BLOCK({0x0FFF, 0});
        break;
    case KIND_PRESS:
    case KIND_RELEASE:
        press(action->kind == KIND_PRESS);
        break;
    default:
        break;
    }
}

// What it says.

bool board_held(void)
{
    return axis()->state == AXIS_ARMED || axis()->state == AXIS_LOADED;
}

bool board_moving(void)
{
    return axis()->state == AXIS_ARMED || axis()->state == AXIS_RUNNING;
}

bool board_finished(void)
{
    return axis()->state == AXIS_DONE;
}

bool board_stopped(void)
{
    bool deaf = *part_deaf;

    *part_deaf = true;
    bool stopped = machine.fault.code != FAULT_none || estop_latched();
    *part_deaf = deaf;
    return stopped;
}

bool board_halted(void)
{
    return engine()->state >= STEP_ENGINE_HALTED;
}

bool board_promise_broken(void)
{
    return (machine.fault.mask & (1uL << FAULT_internal | 1uL << FAULT_stray_steps)) != 0;
}

bool board_estop_recorded(void)
{
    return (machine.fault.mask & 1uL << FAULT_estop) != 0;
}

bool board_excused(const volatile void *address)
{
    const volatile uint8_t *runs =
        (const volatile uint8_t *)&step_engines[0] + offsetof(struct step_engine, runs);
    const volatile uint8_t *byte = address;
    // step_timer_beat() takes the low byte.
    bool beat = address == &step_engines[0].idle_count;

    return beat || (byte >= runs && byte < runs + sizeof step_engines[0].runs);
}

int32_t board_position(void)
{
    uint16_t address = REG_AXIS_BASE + 6u;

    *part_deaf = true;
    uint32_t position =
        (uint32_t)data_input(address) << 16 | data_input((uint16_t)(address + 1u));
    *part_deaf = false;
    return (int32_t)position;
}

// Refused while a step is still to come.
static bool clears(void)
{
    for (uint8_t i = 0; i < TRIES; i++) {
        if (give_order(COMMAND_CLEAR_FAULT, 0) == MODBUS_OK) {
            return true;
        }
        board_idle();
    }
    return false;
}

bool board_recovers(void)
{
    press(false);
    board_idle();
    board_idle();
    if (!clears() || give_order(COMMAND_DISCARD, 0) != MODBUS_OK) {
        return false;
    }
    board_idle();
    int32_t from = judged.position;
    if (BLOCK(START(0), {2, 1}, END) != MODBUS_OK || !arm(0) || !pass_until(finished)) {
        return false;
    }
    judged.permit_given = true;
    return judged.position == from + 2 && board_position() == judged.position &&
           give_order(COMMAND_PERMIT_ON, 0) == MODBUS_OK && part_permit_high();
}

void board_describe(FILE *report)
{
    (void)fprintf(report,
                  "  engine state %u, tail %u, left %d, cut %d; axis state %u; fault %u\n",
                  engine()->state,
                  engine()->tail,
                  engine()->left,
                  engine()->cut,
                  axis()->state,
                  machine.fault.code);
    (void)fprintf(report,
                  "  position %ld, edges made %ld; OCR1A %u, OCR1B %u, TIMSK1 %02X, TIFR1 %02X\n",
                  (long)board_position(),
                  (long)judged.position,
                  part.buffer_top,
                  part.buffer_edge,
                  TIMSK1,
                  TIFR1);
}
