// SPDX-License-Identifier: MIT
// A whole board over the fakes under a host that does what comes to its mind: lines of every kind,
// every command, settings, a clock that stops, jitters and loses edges, switches, the emergency
// stop, late interrupts. All that the host can read and all that leaves the board goes into one
// number a scenario, round by round. A number that changes tells that the board does something else
// than before. If that is meant, the new number is what the suite prints: natively that of a board
// of four axes; a board of two has its own.
#include <stdbool.h>
#include <stdint.h>

#include "app/axes/mark.h"
#include "app/bus/bus_port.h"
#include "app/registers/bits.h"
#include "app/round.h"
#include "app/settings/store.h"
#include "clock/lock_grid.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "fakes/chance.h"
#include "fakes/eeprom.h"
#include "fakes/trace.h"
#include "hal/step_timer.h"
#include "hal/switches.h"
#include "unity.h"
#include "wire/bytes.h"
#include "wire/register_map.h"
#include "wire/server_data.h"

#define ROUNDS    700u // of a scenario
#define SCENARIOS 1u   // of each kind
#define MANY      60u  // and of so many more on the PC, which has the time
#define SETTLED   60u  // rounds in which a clock becomes known

static bool many;           // of each kind many scenarios, on the PC alone
static uint32_t runs;       // how often an axis was seen running
static uint8_t chosen_axes; // the scenario's axes
static uint16_t most_steps; // of a plain pixel
static bool only_seeks;
static uint32_t burst_ends_ticks;
static uint32_t edge_ticks; // distance of the clock's edges

void setUp(void)
{
    trace_begin();
    runs = 0;
    *lock_grid_now() = (struct lock_grid){.locks = false};
}

void tearDown(void)
{
    *lock_grid_now() = (struct lock_grid){.locks = false};
}

static bool now_and_then(uint8_t one_in)
{
    return one_in != 0 && chance_between(1, one_in) == 1;
}

// The clock's errors, of the newest pixel and of those still to come.
static void see_errors(const struct records *records)
{
    uint16_t early = 0;

    for (uint8_t i = 0; i < RECORDS_EARLY; i++) {
        early = (uint16_t)((uint16_t)(early << 1) + (uint16_t)records->early_ticks[i]);
    }
    trace(early);
    if (records->count != 0) {
        trace((uint16_t)records->kept[records->newest].edge_error_ticks);
    }
}

static void see_axis(uint8_t i)
{
    const struct axis *axis = axes_get(i);

    trace((uint16_t)(axis->life.state << 8 | axis->phase));
    trace((uint16_t)(axis->feed.stream.head << 8 | axis->feed.stream.retired));
    trace((uint16_t)(step_timer_state(i) << 8 | step_timer_tail(i)));
    trace((uint16_t)fake_axes[i].steps);
    trace_long(fake_axes[i].last_step_ticks);
    trace(fake_axes[i].enabled);
    trace((uint16_t)axis->ledger.pixel);
    see_errors(&axis->ledger.records);
    if (axis->life.state == AXIS_RUNNING) {
        runs++;
    }
}

static void see_board(void)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        see_axis(i);
    }
    trace(faults_record()->code);
    trace(faults_record()->axis);
    trace(faults_record()->argument);
    trace_long(faults_record()->mask);
    trace((uint16_t)(seek_now()->trip_code << 8 | seek_now()->axis));
    trace((uint16_t)seek_now()->position_steps);
    trace_long(seek_now()->ticks);
    trace(fake_permit);
    trace(fake_watchdog_feeds);
    trace(token_now());
    trace(mark_now()->steady);
    trace(reference_number());
    trace(reference_present());
}

// Some registers of any kind, as a host reads them.
static void read_some(void)
{
    static const uint16_t firsts[] = {0,
                                      REG_AXIS_BASE,
                                      REG_INPUT_fault_mask_high,
                                      REG_ROOM_BASE,
                                      REG_RECORD_BASE,
                                      REG_EVENT_BASE};
    uint16_t address = firsts[chance_between(0, 5)];
    uint8_t bytes[64];

    address = (uint16_t)(address + chance_between(0, 40));
    uint8_t count = (uint8_t)chance_between(1, 30);
    bool mapped = data_input_mapped(address, count);
    trace(mapped);
    if (!mapped) {
        return;
    }
    uint8_t quick = data_inputs(address, count, bytes);
    for (uint8_t i = 0; i < quick; i++) {
        trace(get_word(&bytes[2u * i]));
    }
    for (; quick < count; quick++) {
        trace(data_input((uint16_t)(address + quick)));
    }
}

static void read_others(void)
{
    uint16_t address = (uint16_t)chance_between(0, 40);
    uint16_t count = (uint16_t)chance_between(1, 5);

    for (uint8_t which = SERVER_COILS; which <= SERVER_DISCRETE; which++) {
        trace(data_bits_mapped(address, count, which));
        if (data_bits_mapped(address, 1, which)) {
            trace(data_bit(address, which));
        }
    }
    trace(data_holding_mapped(address, count));
    if (data_holding_mapped(address, 1)) {
        trace(data_holding(address));
    }
    address = (uint16_t)(REG_HOLDING_axis_mask + chance_between(0, 4));
    trace(data_holding_mapped(address, 1));
    trace(store_state());
}

// Queues, entry by entry.

static void queue(uint8_t axis, int16_t count, uint16_t repeat)
{
    trace((uint16_t)bench_entry(axis, count, repeat));
}

static void queue_ramp(uint8_t axis, int16_t each, uint8_t ramp, uint16_t pixels)
{
    for (uint8_t i = 0; i < ramp; i++) {
        queue(axis, (int16_t)((2 * i + 1) * each), 1);
    }
    queue(axis, (int16_t)(2 * ramp * each), pixels);
}

static void queue_ramp_down(uint8_t axis, int16_t each, uint8_t ramp)
{
    for (uint8_t i = ramp; i-- != 0;) {
        queue(axis, (int16_t)((2 * i + 1) * each), 1);
    }
    queue(axis, LINE_MARK_END, 0);
}

static void plain(uint8_t axis, uint16_t flags)
{
    uint16_t most = now_and_then(4) ? 90u : 14u;
    int16_t count = (int16_t)chance_between(1, most_steps != 0 ? most_steps : most);

    queue(axis, (int16_t)(LINE_MARK_START | flags), 0);
    queue(axis, 0, 0);
    for (uint8_t left = (uint8_t)chance_between(1, 5); left != 0; left--) {
        queue(axis, count, (uint16_t)chance_between(1, 6));
        count = (int16_t)(chance_between(0, 5) == 0 ? -count : count + 1);
    }
    if (chance_between(0, 9) != 0) {
        queue(axis, LINE_MARK_END, 0);
    }
}

static void smooth(uint8_t axis, uint16_t flags)
{
    int16_t each = (int16_t)chance_between(1, now_and_then(3) ? 12 : 4);
    uint8_t ramp = (uint8_t)chance_between(1, 3);
    bool play = chance_between(0, 1) == 0;

    queue(axis, (int16_t)(LINE_MARK_START | LINE_START_SMOOTH | flags), 0);
    queue(axis,
          play ? (int16_t)chance_between(1, 2u * (uint16_t)each) : 0,
          play ? (uint16_t)(2 * ramp * each) : 0);
    if (play) {
        queue(axis, 0, 1);
    }
    queue_ramp(axis, each, ramp, (uint16_t)chance_between(1, 6));
    queue_ramp_down(axis, each, ramp);
}

static void seek(uint8_t axis, uint16_t flags)
{
    int16_t each = (int16_t)chance_between(1, 3);

    queue(axis,
          (int16_t)(LINE_MARK_START | LINE_START_SEEK | LINE_START_SMOOTH | flags),
          0);
    queue(axis, 0, 0);
    queue_ramp(axis, each, 2, (uint16_t)chance_between(5, 60));
    queue(axis, LINE_MARK_DOWN, 0);
    queue_ramp_down(axis, each, 2);
}

static void divided(uint8_t axis)
{
    queue(axis, (int16_t)(LINE_MARK_START | LINE_START_WAIT | LINE_START_DIVIDER), 0);
    queue(axis, 0, 0);
    queue(axis, (int16_t)chance_between(1, 3), 0);
    int16_t count = (int16_t)chance_between(1, 30);
    queue(axis, count, (uint16_t)chance_between(1, 5));
    queue(axis, LINE_MARK_END, 0);
}

static void queue_any(uint8_t axis)
{
    uint16_t negative = chance_between(0, 1) == 0 ? 0 : LINE_START_NEGATIVE;

    switch (only_seeks ? chance_between(0, 1) : chance_between(0, 9)) {
    case 0:
        seek(axis, negative | (chance_between(0, 1) == 0 ? 0 : LINE_START_OPEN));
        break;
    case 1:
        plain(axis, 0);
        break;
    case 2:
        smooth(axis, negative);
        break;
    case 3:
        divided(axis);
        break;
    case 4:
    case 5:
    case 6:
        smooth(axis, LINE_START_WAIT | negative);
        break;
    default:
        plain(axis, LINE_START_WAIT);
        break;
    }
}

// Orders.

static void order(uint16_t mask, enum command command, uint16_t argument, uint16_t edge)
{
    uint8_t words[8];

    put_word(&words[0], mask);
    put_word(&words[2], (uint16_t)command);
    put_word(&words[4], argument);
    put_word(&words[6], edge);
    trace((uint16_t)data_write(REG_HOLDING_axis_mask, 4, words));
}

static uint16_t some_axes(void)
{
    uint16_t mask = (uint16_t)chance_between(1, BENCH_ALL_AXES);

    return chance_between(0, 19) == 0 ? (uint16_t)(mask | 8u) : mask;
}

static void arm_loaded(uint16_t token)
{
    uint16_t mask = (uint16_t)(bench_axes_in(AXIS_LOADED) & chosen_axes);

    if (mask != 0) {
        order(mask, COMMAND_ARM, token, 0);
    }
}

static void any_order(void)
{
    static const uint8_t commands[] = {
        COMMAND_ARM,
        COMMAND_DISARM,
        COMMAND_STOP,
        COMMAND_CLEAR_FAULT,
        COMMAND_DISCARD,
        COMMAND_ENABLE,
        COMMAND_DISABLE,
        COMMAND_ZERO,
        COMMAND_ZERO,
        COMMAND_PERMIT_ON,
        COMMAND_PERMIT_OFF,
        COMMAND_STORE,
        COMMAND_DEFAULTS,
        COMMAND_MARK,
        COMMAND_GO,
    };
    enum command command =
        (enum command)commands[chance_between(0, sizeof commands - 1u)];
    uint16_t argument = (uint16_t)chance_between(0, 2);

    if (command == COMMAND_STORE ||
        (command == COMMAND_DEFAULTS && chance_between(0, 7) == 0)) {
        argument = COMMANDS_KEY;
    }
    uint16_t mask = some_axes();
    order(mask, command, argument, bench_edge_ahead((uint16_t)chance_between(0, 9)));
}

static void go(void)
{
    uint16_t token = token_now();

    if (token != 0) {
        order(1, COMMAND_GO, token, bench_edge_ahead((uint16_t)chance_between(3, 25)));
    }
}

static void any_coils(void)
{
    uint16_t address = (uint16_t)chance_between(0, 13);
    uint16_t count = (uint16_t)chance_between(1, 4);
    uint16_t values = (uint16_t)chance();
    uint8_t bits[2] = {(uint8_t)values, (uint8_t)(values >> 8)};

    if (data_bits_mapped(address, count, SERVER_COILS)) {
        trace((uint16_t)data_write_coils(address, count, bits));
    }
}

static void any_setting(void)
{
    static const uint8_t places[] = {REG_HOLDING_dir_setup_us,
                                     REG_HOLDING_max_acceleration,
                                     REG_HOLDING_input_filter_us,
                                     REG_HOLDING_start_stop_steps,
                                     REG_HOLDING_idle_off_ms,
                                     REG_HOLDING_enable_settle_ms,
                                     REG_HOLDING_hold_over_edges,
                                     REG_HOLDING_record_every,
                                     REG_HOLDING_home_is_limit,
                                     REG_HOLDING_inputs_inverted};
    uint8_t words[2];

    put_word(words, (uint16_t)chance_between(0, chance_between(0, 3) == 0 ? 300 : 8));
    trace((uint16_t)data_write(places[chance_between(0, sizeof places - 1u)], 1, words));
}

// The world.

static void clock_from(uint32_t ticks)
{
    fake_pixel_clock(fake_now_ticks() + ticks, CONFIG_TIMER_HZ, edge_ticks);
}

static void disturb_clock(void)
{
    uint32_t next = fake_next_edge_ticks();

    switch (chance_between(0, 7)) {
    case 0: // the next edge early or late
        fake_pixel_clock(
            next + chance_between(0, edge_ticks / 3u), CONFIG_TIMER_HZ, edge_ticks);
        break;
    case 1: // a little jitter
    case 2:
        fake_pixel_clock(
            next + chance_between(0, edge_ticks / 40u), CONFIG_TIMER_HZ, edge_ticks);
        break;
    case 3: // edges are missing
        fake_pixel_clock(
            next + edge_ticks * chance_between(1, 4), CONFIG_TIMER_HZ, edge_ticks);
        break;
    case 4:
        fake_crowded_edge();
        break;
    case 5: // the clock rests, and comes back
        fake_pixel_clock(0, 0, 0);
        break;
    case 6:
        fake_pixel_clock(
            next, CONFIG_TIMER_HZ, edge_ticks + chance_between(0, edge_ticks / 60u));
        break;
    default:
        clock_from(chance_between(1000, 90000));
        break;
    }
}

static void switch_any(void)
{
    static const uint8_t which[] = {
        SWITCH_HOME, SWITCH_HOME, SWITCH_LIMIT_MINUS, SWITCH_LIMIT_PLUS};
    uint8_t axis = (uint8_t)chance_between(0, CONFIG_AXES - 1u);
    uint8_t one = which[chance_between(0, 3)];

    if (only_seeks && seek_now()->axis < CONFIG_AXES) {
        axis = seek_now()->axis;
        one = SWITCH_HOME;
    }
    // It bounces, for longer or shorter than it is filtered.
    for (uint8_t left = (uint8_t)chance_between(0, 4); left != 0; left--) {
        fake_switch(axis, one, (left & 1u) != 0);
        fake_pass(chance_between(20, now_and_then(4) ? 9000 : 400));
        if (now_and_then(3)) {
            round_poll();
        }
    }
    fake_switch(axis, one, chance_between(0, 2) != 0);
}

static void break_something(void)
{
    uint8_t axis = (uint8_t)chance_between(0, CONFIG_AXES - 1u);

    switch (chance_between(0, 5)) {
    case 0:
        fake_estop(false);
        break;
    case 1:
        fake_underrun(axis);
        break;
    case 2:
        fake_missed_period(axis);
        break;
    case 3:
        fake_slow_publish(chance_between(1000, 60000));
        break;
    case 4:
        fake_pass(chance_between(20000, 120000)); // the main loop is held
        break;
    default:
        if (axes_get(axis)->life.state == AXIS_EMPTY) {
            fake_stray_steps(axis);
        }
        break;
    }
}

// As an operator does: everything off, faults cleared, the clock as it should be.
static void recover(void)
{
    fake_estop(true);
    order(BENCH_ALL_AXES, COMMAND_STOP, 0, 0);
    bench_rounds(20);
    order(1, COMMAND_CLEAR_FAULT, 0, 0);
    clock_from(5000);
}

struct scenario {
    uint16_t sync;
    uint16_t gate_edges;
    uint16_t divider;
    uint16_t clock_hz;
    uint8_t disturbs; // one round in so many: the clock; 0 never
    uint8_t switches;
    uint8_t breaks;
    uint8_t orders;
    uint16_t steps; // most of a plain pixel; 0: few
    uint16_t ticks; // most of a round; 0: as many as usual
    uint16_t slow;  // most ticks that a section of a round takes
    bool seeks;     // lines are seeks, and switches are those of the seeking axis
    uint8_t bursts; // edges of a burst of the clock; 0: it does not rest
};

static void host(const struct scenario *scenario)
{
    uint8_t axis = (uint8_t)chance_between(0, CONFIG_AXES - 1u);

    if (now_and_then(6) && axes_get(axis)->life.state != AXIS_STOPPING &&
        axes_get(axis)->whole_lines < 3u) {
        queue_any(axis);
    }
    if (now_and_then(8)) {
        arm_loaded(now_and_then(3) ? 5u : 0);
    }
    if (now_and_then(8)) {
        go();
    }
    if (now_and_then(scenario->orders)) {
        any_order();
    }
    if (now_and_then(60)) {
        any_coils();
    }
    if (now_and_then(40)) {
        any_setting();
    }
    if (now_and_then(6)) {
        read_some();
        read_others();
    }
    if (faults_any() && now_and_then(10)) {
        recover();
    }
}

// A burst of the clock ends, and after a rest the next one begins.
static void go_on_with_bursts(const struct scenario *scenario)
{
    if ((int32_t)(fake_now_ticks() - burst_ends_ticks) < 0) {
        return;
    }
    uint32_t rest_ticks = edge_ticks * chance_between(2, now_and_then(3) ? 100 : 12);
    uint32_t edges = chance_between(scenario->bursts / 2u, scenario->bursts);

    fake_pixel_clock(0, 0, 0);
    fake_pass(rest_ticks / 2u);
    round_poll();
    fake_pass(rest_ticks - rest_ticks / 2u);
    round_poll();
    clock_from(1000);
    burst_ends_ticks = fake_now_ticks() + edges * edge_ticks;
}

static void world(const struct scenario *scenario)
{
    if (now_and_then(scenario->disturbs)) {
        disturb_clock();
    }
    if (now_and_then(scenario->switches)) {
        switch_any();
    }
    if (now_and_then(scenario->breaks)) {
        break_something();
    }
    if (scenario->bursts != 0) {
        go_on_with_bursts(scenario);
    }
    if (scenario->slow != 0) {
        fake_slow_sections(chance_between(0, scenario->slow));
    }
    uint32_t most = now_and_then(20) ? 12000u : 4000u;

    fake_pass(chance_between(500, scenario->ticks != 0 ? scenario->ticks : most));
}

static void open_board(const struct scenario *scenario)
{
    struct settings *settings = bench_settings();

    bench_power_on();
    settings->sync = scenario->sync;
    settings->gate_edges = scenario->gate_edges;
    settings->divider = scenario->divider;
    settings->pixel_hz_num[1] = scenario->clock_hz;
    settings->bus_timeout_ms = 0;
    limits_apply_settings();
    edge_ticks = CONFIG_TIMER_HZ / scenario->clock_hz;
    most_steps = scenario->steps;
    only_seeks = scenario->seeks;
    burst_ends_ticks = fake_now_ticks();
    clock_from(5000);
    bench_rounds(SETTLED);
}

static void see_scenarios(const struct scenario *scenario, uint8_t scenarios)
{
    for (; scenarios != 0; scenarios--) {
        open_board(scenario);
        chosen_axes = (uint8_t)chance_between(1, BENCH_ALL_AXES);
        for (uint16_t left = ROUNDS; left != 0; left--) {
            host(scenario);
            world(scenario);
            round_poll();
            see_board();
        }
    }
}

static void check(uint32_t wanted)
{
    TEST_ASSERT_EQUAL_HEX32(wanted, trace_number());
}

// The numbers of a kind: of a board of four axes and of two; and natively of many more scenarios.
static void play(const struct scenario *scenario,
                 uint32_t seed,
                 uint32_t four,
                 uint32_t two,
                 uint32_t of_many)
{
    chance_seed(many ? ~seed : seed);
    see_scenarios(scenario, many ? MANY : SCENARIOS);
    TEST_ASSERT_TRUE(!many || runs > 5u * ROUNDS);
    if (many) {
        check(of_many);
    } else {
        check(CONFIG_AXES > 2 ? four : two);
    }
}

static void lines_begin_on_the_clock(void)
{
    static const struct scenario scenario = {
        .sync = SYNC_START, .divider = 1, .clock_hz = 2500, .orders = 60};

    play(&scenario, 0xB0A1uL, 0xCE10C3D4uL, 0x4AFACB4DuL, 0x945BC94CuL);
}

static void the_clock_is_poor(void)
{
    static const struct scenario scenario = {
        .sync = SYNC_START, .divider = 1, .clock_hz = 2000, .disturbs = 40, .orders = 80};

    play(&scenario, 0xB0A2uL, 0xAC782F43uL, 0xC1342FC3uL, 0x4F91B081uL);
}

static void several_edges_a_pixel(void)
{
    static const struct scenario scenario = {
        .sync = SYNC_START, .divider = 3, .clock_hz = 3000, .disturbs = 90, .orders = 80};

    play(&scenario, 0xB0A3uL, 0x5D8AC3E5uL, 0xEC37B899uL, 0x7AC8FB58uL);
}

static void lines_are_locked(void)
{
    static const struct scenario scenario = {
        .sync = SYNC_LOCK, .divider = 1, .clock_hz = 2500, .disturbs = 120, .orders = 90};

    play(&scenario, 0xB0A4uL, 0xEA95B401uL, 0x4F362F22uL, 0x2DADE973uL);
}

static void locked_to_a_divided_clock(void)
{
    static const struct scenario scenario = {
        .sync = SYNC_LOCK, .divider = 4, .clock_hz = 4000, .disturbs = 120, .orders = 90};

    play(&scenario, 0xB0A5uL, 0xFFC9E361uL, 0x0DB629E3uL, 0x1C7B4ACEuL);
}

static void the_clock_is_gated(void)
{
    static const struct scenario scenario = {.sync = SYNC_START,
                                             .gate_edges = 10,
                                             .bursts = 60,
                                             .divider = 1,
                                             .clock_hz = 2500,
                                             .disturbs = 90,
                                             .orders = 90};

    play(&scenario, 0xB0A6uL, 0x883D5867uL, 0x954ECACEuL, 0xD75800E1uL);
}

static void locked_to_a_gated_clock(void)
{
    static const struct scenario scenario = {.sync = SYNC_LOCK,
                                             .gate_edges = 20,
                                             .bursts = 90,
                                             .divider = 1,
                                             .clock_hz = 2500,
                                             .disturbs = 120,
                                             .orders = 90};

    play(&scenario, 0xB0A7uL, 0x7D0C6358uL, 0x558DB5A0uL, 0x9FB2B683uL);
}

static void nobody_follows_the_clock(void)
{
    static const struct scenario scenario = {
        .sync = SYNC_FREE, .divider = 1, .clock_hz = 1500, .disturbs = 60, .orders = 50};

    play(&scenario, 0xB0A8uL, 0x07AAF5E3uL, 0x56A1851BuL, 0x28074130uL);
}

static void every_axis_has_much_to_do(void)
{
    static const struct scenario scenario = {.sync = SYNC_START,
                                             .divider = 1,
                                             .clock_hz = 150,
                                             .orders = 200,
                                             .steps = 330,
                                             .ticks = 20000,
                                             .slow = 1500};

    play(&scenario, 0xB0ABuL, 0x313F93C6uL, 0xF9B20851uL, 0xEC516E12uL);
}

static void every_axis_is_locked_and_busy(void)
{
    static const struct scenario scenario = {.sync = SYNC_LOCK,
                                             .divider = 2,
                                             .clock_hz = 600,
                                             .disturbs = 200,
                                             .orders = 200,
                                             .steps = 130,
                                             .ticks = 12000,
                                             .slow = 1200};

    play(&scenario, 0xB0ACuL, 0xB0536ACFuL, 0xEB7AD28CuL, 0x4D027954uL);
}

static void edges_come_faster_than_rounds(void)
{
    static const struct scenario scenario = {.sync = SYNC_START,
                                             .divider = 2,
                                             .clock_hz = 9000,
                                             .disturbs = 60,
                                             .orders = 120,
                                             .ticks = 5000,
                                             .slow = 400};

    play(&scenario, 0xB0ADuL, 0x8DB5DA73uL, 0xBD86DBC2uL, 0x6FCA6D51uL);
}

static void switches_trip(void)
{
    static const struct scenario scenario = {
        .sync = SYNC_START, .divider = 1, .clock_hz = 2500, .switches = 25, .orders = 60};

    play(&scenario, 0xB0A9uL, 0x281906A5uL, 0x2ACAF854uL, 0xE6C0A9D3uL);
}

static void axes_seek(void)
{
    static const struct scenario scenario = {.sync = SYNC_START,
                                             .divider = 1,
                                             .clock_hz = 2500,
                                             .switches = 30,
                                             .orders = 40,
                                             .seeks = true};

    play(&scenario, 0xB0AEuL, 0x548E7D65uL, 0xA2A2E88CuL, 0x90894F54uL);
}

static void things_break(void)
{
    static const struct scenario scenario = {.sync = SYNC_START,
                                             .divider = 1,
                                             .clock_hz = 2500,
                                             .disturbs = 200,
                                             .switches = 200,
                                             .breaks = 60,
                                             .orders = 60};

    play(&scenario, 0xB0AAuL, 0x9CD8073CuL, 0x027EE594uL, 0x66D98B6DuL);
}

// Parts of the firmware remember what was before a scenario, so that the order counts.
static void run_all(void)
{
    RUN_TEST(lines_begin_on_the_clock);
    RUN_TEST(the_clock_is_poor);
    RUN_TEST(several_edges_a_pixel);
    RUN_TEST(lines_are_locked);
    RUN_TEST(locked_to_a_divided_clock);
    RUN_TEST(the_clock_is_gated);
    RUN_TEST(locked_to_a_gated_clock);
    RUN_TEST(nobody_follows_the_clock);
    RUN_TEST(every_axis_has_much_to_do);
    RUN_TEST(every_axis_is_locked_and_busy);
    RUN_TEST(edges_come_faster_than_rounds);
    RUN_TEST(switches_trip);
    RUN_TEST(axes_seek);
    RUN_TEST(things_break);
}

int main(void)
{
    UNITY_BEGIN();
    run_all();
#if !defined(__AVR__)
    many = true;
    run_all();
#endif
    return UNITY_END();
}
