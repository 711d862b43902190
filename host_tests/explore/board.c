// SPDX-License-Identifier: MIT
#include "explore/board.h"

#include <avr/io.h>
#include <stddef.h>

#include "app/board.h"
#include "app/round.h"
#include "app/watch/safety.h"
#include "app/watch/time_check.h"
#include "explore/judge.h"
#include "explore/judged.h"
#include "explore/part.h"
#include "explore/scene.h"
#include "hal/estop.h"
#include "hal/pins.h"
#include "wire/bytes.h"
#include "wire/register_map.h"
#include "wire/server_data.h"

#define PASS_MAX 200u // most periods until an awaited event has come
#define TRIES    4u   // most attempts to clear a fault

void scene_pixel_hz(uint16_t hz)
{
    settings_record()->pixel_hz_num[1] = hz;
    limits_apply_settings();
}

void board_power_on(void)
{
    part_power_on();
    part_share(step_engines, sizeof step_engines);
    part_share(step_rings, sizeof step_rings);
    pins_start();
    board_start();
    settings_record()->enable_settle_ms = 0;
    settings_record()->bus_timeout_ms = 0;
    scene_pixel_hz(100);
    time_check_start();
    part_sei();
    safety_start();
}

void board_round(void)
{
    scene_pass_ms();
    round_poll();
}

void board_idle(void)
{
    part.points = 0;
    part_point();
    if (part_possible(PART_PERIOD_ENDS)) {
        part_happen(PART_PERIOD_ENDS);
    }
    part_point();
    board_round();
    part_point();
    judge_between();
}

bool scene_order(uint16_t command, uint16_t argument)
{
    uint8_t words[6];

    put_word(&words[0], 1);
    put_word(&words[2], command);
    put_word(&words[4], argument);
    return data_write(REG_HOLDING_axis_mask, 3, words) == MODBUS_OK;
}

bool scene_block(const struct segment *segments, uint8_t count)
{
    uint8_t words[4 + 4 * 32];

    put_word(&words[0], scene_axis()->next_block);
    put_word(&words[2], 0);
    for (uint8_t i = 0; i < count; i++) {
        put_word(&words[4u + 4u * i], (uint16_t)segments[i].count);
        put_word(&words[6u + 4u * i], segments[i].repeat);
    }
    return data_write(REG_QUEUE_WINDOW, (uint16_t)(2u + 2u * count), words) == MODBUS_OK;
}

void scene_press(bool pressed)
{
    if (part_estop_pressed() != pressed) {
        part_happen(PART_PIN_CHANGES);
    }
}

bool scene_arm(uint16_t token)
{
    judged.edges_allowed = JUDGE_ANY_NUMBER;
    return scene_order(COMMAND_ARM, token);
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

bool board_held(void)
{
    return lifecycle_armed(&scene_axis()->life) ||
           scene_axis()->life.state == AXIS_LOADED;
}

bool board_moving(void)
{
    return lifecycle_moving(&scene_axis()->life);
}

bool board_finished(void)
{
    return scene_axis()->life.state == AXIS_DONE;
}

bool board_stopped(void)
{
    bool deaf = *part_reception_off;

    *part_reception_off = true;
    bool stopped = faults_record()->code != FAULT_none || estop_latched();
    *part_reception_off = deaf;
    return stopped;
}

bool board_halted(void)
{
    return scene_engine()->state >= STEP_ENGINE_HALTED;
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

bool board_excused(const struct part_access *access)
{
    const volatile void *address = access->address;
    const volatile uint8_t *trains =
        (const volatile uint8_t *)&step_engines[0] + offsetof(struct step_engine, trains);
    const volatile uint8_t *byte = address;
    // step_timer_heartbeat() takes the low byte. A command's handler counts an idle period with
    // interrupts on; only a capture could read half of that count, and captures are not explored.
    bool idle_count = address == &step_engines[0].idle_count;

    return idle_count ||
           (byte >= trains && byte < trains + sizeof step_engines[0].trains);
}

int32_t board_position(void)
{
    uint16_t address = REG_AXIS_BASE + 6u;

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
        if (scene_order(COMMAND_CLEAR_FAULT, 0)) {
            return true;
        }
        board_idle();
    }
    return false;
}

bool board_recovers(void)
{
    scene_press(false);
    board_idle();
    board_idle();
    if (!clears() || !scene_order(COMMAND_DISCARD, 0)) {
        return false;
    }
    board_idle();
    int32_t from = judged.position;
    if (!BLOCK(START(0), {2, 1}, END) || !scene_arm(0) ||
        !scene_pass_until(board_finished)) {
        return false;
    }
    judged.permit_given = true;
    return judged.position == from + 2 && board_position() == judged.position &&
           scene_order(COMMAND_PERMIT_ON, 0) && part_permit_high();
}

void board_describe(FILE *report)
{
    (void)fprintf(
        report,
        "  engine state %u, tail %u, left %d, cut %d; axis state %u; fault %u\n",
        scene_engine()->state,
        scene_engine()->tail,
        scene_engine()->left,
        scene_engine()->cut,
        scene_axis()->life.state,
        faults_record()->code);
    (void)fprintf(
        report,
        "  position %ld, edges made %ld; OCR1A %u, OCR1B %u, TIMSK1 %02X, TIFR1 %02X\n",
        (long)board_position(),
        (long)judged.position,
        part.timers[0].buffer_top,
        part.timers[0].buffer_edge,
        TIMSK1,
        TIFR1);
}
