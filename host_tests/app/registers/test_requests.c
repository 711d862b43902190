// SPDX-License-Identifier: MIT
// Random orders, coils and settings in every state that random lines, faults and rests lead to: a
// refused request changes nothing at all, and a coil is taken exactly when its order is.
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "app/registers/bits.h"
#include "app/settings/store.h"
#include "app/watch/drivers.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "fakes/chance.h"
#include "hal/step_timer.h"
#include "unity.h"
#include "wire/bytes.h"
#include "wire/register_map.h"

#define REQUESTS     3000u
#define REQUESTS_MAX 20000u // until every state was met
#define TOKEN        5u
#define STATES       ((uint16_t)((1u << AXIS_STATES) - 1u))

// What a request must not touch when it is refused, as far as anybody can see it: a hash of each
// part, because the parts themselves would not fit the smaller RAM twice.
enum part {
    PART_AXES,
    PART_FAULT,
    PART_SETTINGS,
    PART_WATCH,
    PART_LIMITS,
    PART_SEEK,
    PART_LAST_ORDER,
    PART_OUTPUTS,
    PART_ENGINES,
    PART_REST,
    PARTS,
};

static uint32_t before[PARTS];
static uint32_t after[PARTS];
static uint16_t states_met;
static uint16_t taken;
static uint16_t refused;

// FNV-1a, 32 bits.
static uint32_t hash(uint32_t so_far, const void *object, size_t bytes)
{
    const uint8_t *byte = object;

    for (; bytes != 0; bytes--) {
        so_far = (so_far ^ *byte) * 16777619uL;
        byte++;
    }
    return so_far;
}

static void observe(uint32_t *parts)
{
    uint16_t rest[] = {
        token_now(), store_state(), drivers_on(), permit_is_on(), fake_permit};

    memset(parts, 0, PARTS * sizeof *parts);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        uint8_t engine = (uint8_t)step_timer_state(i);
        parts[PART_AXES] = hash(parts[PART_AXES], axes_get(i), sizeof(struct axis));
        parts[PART_ENGINES] = hash(parts[PART_ENGINES] + i, &engine, 1);
        states_met = (uint16_t)(states_met | 1u << axes_get(i)->life.state);
    }
    parts[PART_FAULT] = hash(1, faults_record(), sizeof(struct fault_record));
    parts[PART_SETTINGS] = hash(1, settings_now(), sizeof(struct settings));
    parts[PART_WATCH] = hash(1, reference_watch(), sizeof(struct clock_watch));
    parts[PART_LIMITS] =
        hash(1, limits_together(CONFIG_AXES), sizeof(struct line_limits));
    parts[PART_SEEK] = hash(1, seek_now(), sizeof(struct seek));
    parts[PART_LAST_ORDER] = hash(1, commands_last(), sizeof(struct order));
    parts[PART_OUTPUTS] = hash(1, fake_axes, sizeof fake_axes);
    parts[PART_REST] = hash(1, rest, sizeof rest);
}

static void check(enum modbus_exception answer)
{
    if (answer == MODBUS_OK) {
        taken++;
        return;
    }
    refused++;
    observe(after);
    TEST_ASSERT_EQUAL_HEX32_ARRAY(before, after, PARTS);
}

static uint16_t random_argument(void)
{
    static const uint16_t arguments[] = {0, 0, 0, TOKEN, TOKEN, TOKEN + 1u, COMMANDS_KEY};

    return arguments[chance_between(0, sizeof arguments / sizeof arguments[0] - 1u)];
}

static void give_order(void)
{
    uint8_t words[6];

    put_word(&words[0], (uint16_t)chance_between(0, COMMANDS_MASK_MAX + 1u));
    put_word(&words[2], (uint16_t)chance_between(0, COMMAND_LAST + 1u));
    put_word(&words[4], random_argument());
    check(data_write(REG_HOLDING_axis_mask, (uint16_t)chance_between(1, 3), words));
}

// What 0 and 1 ask for, in the order of the coils.
static uint16_t command_of(uint8_t coil, bool value)
{
    static const uint8_t commands[][2] = {
        {COMMAND_DISABLE, COMMAND_ENABLE},
        {COMMAND_DISARM, COMMAND_ARM},
        {COMMAND_NONE, COMMAND_STOP},
        {COMMAND_NONE, COMMAND_CLEAR_FAULT},
        {COMMAND_PERMIT_OFF, COMMAND_PERMIT_ON},
    };

    return commands[coil < 12u ? coil / 4u : coil - 9u][value];
}

static void write_one_coil(void)
{
    uint8_t coil = (uint8_t)chance_between(0, BITS_COILS - 1u);
    const uint8_t bits[2] = {(uint8_t)chance_between(0, 1), 0};
    const struct order order = {
        .mask = (uint16_t)(1u << (coil < 12u ? coil % 4u : 0u)),
        .command = command_of(coil, bits[0] != 0),
    };

    if (data_bits_mapped(coil, 1, SERVER_COILS)) {
        bool possible = commands_possible(&order);
        enum modbus_exception answer = data_write_coils(coil, 1, bits);
        TEST_ASSERT_EQUAL(possible, answer == MODBUS_OK);
        check(answer);
    }
}

static void write_coils(void)
{
    uint8_t first = (uint8_t)chance_between(0, BITS_COILS - 1u);
    uint8_t count = (uint8_t)chance_between(1, BITS_COILS - first);
    uint16_t values = (uint16_t)chance_between(0, UINT16_MAX);
    const uint8_t bits[2] = {(uint8_t)values, (uint8_t)(values >> 8)};

    if (data_bits_mapped(first, count, SERVER_COILS)) {
        check(data_write_coils(first, count, bits));
    }
}

static void write_settings(void)
{
    uint8_t words[8];
    uint16_t first =
        (uint16_t)chance_between(REG_HOLDING_dir_setup_us, SETTINGS_WORDS - 4u);

    for (uint8_t i = 0; i < 4; i++) {
        uint16_t now = data_holding((uint16_t)(first + i));
        put_word(&words[2u * i],
                 chance_between(0, 3) == 0 ? (uint16_t)chance_between(0, 3000) : now);
    }
    check(data_write(first, (uint16_t)chance_between(1, 4), words));
}

static void queue_line(void)
{
    uint8_t axis = (uint8_t)chance_between(0, CONFIG_AXES - 1u);
    uint16_t start =
        (uint16_t)(LINE_MARK_START | (chance_between(0, 1) ? LINE_START_WAIT : 0));

    if (chance_between(0, 9) == 0) {
        (void)bench_entry(axis, 20000, 1); // refused: the axis is, too
        return;
    }
    (void)bench_entry(axis, (int16_t)start, 0);
    (void)bench_entry(axis, 0, 0);
    (void)bench_entry(
        axis, (int16_t)chance_between(1, 30), (uint16_t)chance_between(1, 9));
    if (chance_between(0, 3) != 0) {
        (void)bench_entry(axis, LINE_MARK_END, 0);
    }
}

static void disturb(void)
{
    switch (chance_between(0, 7)) {
    case 0:
        fake_estop(false);
        break;
    case 1:
    case 2:
    case 3:
        fake_estop(true);
        break;
    case 4:
        bench_clock_off();
        break;
    default:
        bench_clock_on();
        break;
    }
}

// Requests in a row, mostly: without time in between their states would be few.
static void step(void)
{
    observe(before);
    switch (chance_between(0, 9)) {
    case 0:
    case 1:
    case 2:
        give_order();
        break;
    case 3:
        write_one_coil();
        break;
    case 4:
        write_coils();
        break;
    case 5:
        write_settings();
        break;
    case 6:
    case 7:
        queue_line();
        break;
    case 8:
        // Now and then long enough for a line to come to its end.
        bench_rounds((uint16_t)chance_between(1, chance_between(0, 7) == 0 ? 500 : 60));
        break;
    default:
        if (chance_between(0, 9) == 0) {
            disturb();
        }
        bench_rounds(1);
        break;
    }
}

void setUp(void)
{
    bench_power_on();
    chance_seed(20241122u);
}

void tearDown(void)
{
}

static void refused_requests_change_nothing(void)
{
    for (uint16_t i = 0; i < REQUESTS || (states_met != STATES && i < REQUESTS_MAX);
         i++) {
        step();
    }
    // The walk met every state, and both answers often.
    TEST_ASSERT_EQUAL_HEX16(STATES, states_met);
    TEST_ASSERT_TRUE(taken > REQUESTS / 20u);
    TEST_ASSERT_TRUE(refused > REQUESTS / 20u);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(refused_requests_change_nothing);
    return UNITY_END();
}
