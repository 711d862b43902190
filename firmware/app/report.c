// SPDX-License-Identifier: MIT
// What each input register shows: a table in flash, because a function with a case for each of them
// takes three times the room.
#include "app/report.h"

#include <stddef.h> // offsetof

#include "app/inputs.h"        // inputs_all
#include "app/machine.h"       // machine
#include "app/serial.h"        // serial_counters
#include "app/store.h"         // store_state
#include "base/flash.h"        // IN_FLASH
#include "hal/cpu.h"           // cpu_reset_cause
#include "hal/estop.h"         // estop_tripped
#include "wire/bytes.h"        // half_word
#include "wire/register_map.h" // REG_*

#define OUTPUTS_PERMIT 0x0100u

uint16_t report_status(void)
{
    uint16_t bits = machine_clock_present() ? REPORT_CLOCK : 0;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (machine_axis(i)->state == AXIS_ARMED) {
            bits |= REPORT_ARMED;
        } else if (machine_axis(i)->state == AXIS_RUNNING) {
            bits |= REPORT_RUNNING;
        }
    }
    if (machine.fault.code != FAULT_none) {
        bits |= REPORT_FAULT;
    }
    if (estop_tripped()) {
        bits |= REPORT_ESTOP;
    }
    if (serial_counters()->listen_only) {
        bits |= REPORT_LISTEN_ONLY;
    }
    return machine.permit ? (uint16_t)(bits | REPORT_PERMIT) : bits;
}

static uint16_t status(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return report_status();
}

static uint16_t reset_cause(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return cpu_reset_cause();
}

static uint16_t inputs(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return inputs_all();
}

static uint16_t outputs(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return (uint16_t)(machine.drivers.on | (machine.permit ? OUTPUTS_PERMIT : 0));
}

static uint16_t settings_state(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return store_state();
}

static uint16_t queue_free(uint8_t axis, bool low)
{
    (void)low;
    return run_queue_free(&machine_axis(axis)->queue);
}

static uint16_t ring_fill(uint8_t axis, bool low)
{
    (void)low;
    return axis_ring_fill(machine_axis(axis));
}

// Now, as the first of the two words is read; the second belongs to it.
static uint16_t position_steps(uint8_t axis, bool low)
{
    if (!low) {
        (void)machine_follow(axis);
    }
    return half_word((uint32_t)ledger_position(&machine_axis(axis)->ledger), low);
}

static uint16_t expected_steps(uint8_t axis, bool low)
{
    const struct ledger *ledger = &machine_axis(axis)->ledger;
    uint8_t newest = ledger->record_next == 0 ? LEDGER_RECORDS : ledger->record_next;

    return ledger->record_count == 0
               ? 0
               : half_word((uint32_t)ledger->records[newest - 1u].expected_steps, low);
}

enum source_kind {
    SOURCE_CONSTANT,
    SOURCE_COUNTER, // by its place in the server's
    SOURCE_BYTE,
    SOURCE_WORD,
    SOURCE_HIGH, // words of 32 bits
    SOURCE_LOW,
    SOURCE_CALL_HIGH,
    SOURCE_CALL_LOW,
};

// Of an axis's register: in or for axis 0.
struct source {
    union {
        const void *at;
        uint16_t constant;
        uint16_t (*call)(uint8_t axis, bool low);
    };
    uint8_t kind;
};

#define CONSTANT(value) {.constant = (value), .kind = SOURCE_CONSTANT}
#define COUNTER(name)                                                                    \
    {.constant = offsetof(struct server_counters, name), .kind = SOURCE_COUNTER}
#define BYTE(variable) {.at = &(variable), .kind = SOURCE_BYTE}
#define WORD(variable) {.at = &(variable), .kind = SOURCE_WORD}
#define CALL(function) {.call = (function), .kind = SOURCE_CALL_LOW}
#define LONG(first, variable)                                                            \
    [first] = {.at = &(variable), .kind = SOURCE_HIGH},                                  \
    [(first) + 1] = {.at = &(variable), .kind = SOURCE_LOW}
#define CALL_LONG(first, function)                                                       \
    [first] = {.call = (function), .kind = SOURCE_CALL_HIGH},                            \
    [(first) + 1] = {.call = (function), .kind = SOURCE_CALL_LOW}

static const struct source board[] IN_FLASH = {
    [REG_INPUT_map_version] = CONSTANT(REG_MAP_VERSION),
    [REG_INPUT_firmware_version] =
        CONSTANT(CONFIG_VERSION_MAJOR * 256u + CONFIG_VERSION_MINOR),
    [REG_INPUT_board_id] = CONSTANT(CONFIG_BOARD_ID),
    [REG_INPUT_axis_count] = CONSTANT(CONFIG_AXES),
    [REG_INPUT_status] = CALL(status),
    [REG_INPUT_fault_code] = BYTE(machine.fault.code),
    [REG_INPUT_fault_argument] = WORD(machine.fault.argument),
    [REG_INPUT_fault_axis] = BYTE(machine.fault.axis),
    LONG(REG_INPUT_fault_pixel, machine.fault.pixel),
    [REG_INPUT_fault_mask] = {.at = &machine.fault.mask, .kind = SOURCE_LOW},
    [REG_INPUT_reset_cause] = CALL(reset_cause),
    LONG(REG_INPUT_pixel_edges, machine.watch.edges),
    [REG_INPUT_edge_error_ticks] = WORD(machine.watch.error_ticks),
    [REG_INPUT_edge_error_max_ticks] = WORD(machine.watch.error_max_ticks),
    [REG_INPUT_frames_ok] = COUNTER(frames_ok),
    [REG_INPUT_crc_errors] = COUNTER(crc_errors),
    [REG_INPUT_exceptions] = COUNTER(exceptions),
    [REG_INPUT_rx_overruns] = COUNTER(rx_overruns),
    LONG(REG_INPUT_pixel_period_ticks, machine.period.whole_ticks),
    [REG_INPUT_min_interval_ticks] = CONSTANT(CONFIG_MIN_INTERVAL_TICKS),
    [REG_INPUT_smooth_min_interval_ticks] = CONSTANT(CONFIG_SMOOTH_MIN_INTERVAL_TICKS),
    [REG_INPUT_record_capacity] = CONSTANT(LEDGER_RECORDS),
    [REG_INPUT_inputs] = CALL(inputs),
    [REG_INPUT_trip_code] = BYTE(machine.seek.trip_code),
    [REG_INPUT_trip_axis] = BYTE(machine.seek.trip_axis),
    LONG(REG_INPUT_trip_position_steps, machine.seek.position_steps),
    LONG(REG_INPUT_trip_ticks, machine.seek.ticks),
};

static const struct source axes[] IN_FLASH = {
    [REG_AXIS_axis_state] = BYTE(machine.axes[0].state),
    [REG_AXIS_queue_free] = CALL(queue_free),
    [REG_AXIS_next_block] = WORD(machine.axes[0].next_block),
    [REG_AXIS_line_error] = BYTE(machine.axes[0].line_error),
    LONG(REG_AXIS_line_error_pixel, machine.axes[0].line_error_pixel),
    CALL_LONG(REG_AXIS_position_steps, position_steps),
    CALL_LONG(REG_AXIS_expected_steps, expected_steps),
    LONG(REG_AXIS_pixel, machine.axes[0].ledger.pixel),
    [REG_AXIS_lines_done] = WORD(machine.axes[0].lines_done),
    [REG_AXIS_underruns] = WORD(machine.axes[0].underruns),
    [REG_AXIS_line_warning] = BYTE(machine.axes[0].line_warning),
    [REG_AXIS_ring_fill] = CALL(ring_fill),
};

#define MORE_BASE REG_INPUT_fault_mask_high
static const struct source more[] IN_FLASH = {
    [REG_INPUT_fault_mask_high - MORE_BASE] = {.at = &machine.fault.mask,
                                               .kind = SOURCE_HIGH},
    [REG_INPUT_outputs - MORE_BASE] = CALL(outputs),
    [REG_INPUT_settings_state - MORE_BASE] = CALL(settings_state),
    [REG_INPUT_settings_serial - MORE_BASE] = WORD(machine.settings.serial),
    [REG_INPUT_bus_messages - MORE_BASE] = COUNTER(bus_messages),
    [REG_INPUT_no_replies - MORE_BASE] = COUNTER(no_replies),
    [REG_INPUT_busy_replies - MORE_BASE] = COUNTER(busy_replies),
    [REG_INPUT_event_capacity - MORE_BASE] = CONSTANT(CONFIG_EVENTS),
};

#define COUNT(table) (sizeof(table) / sizeof((table)[0]))
_Static_assert(COUNT(board) == REG_AXIS_BASE, "the first area ends where the axes begin");
_Static_assert(COUNT(axes) == REG_AXIS_STRIDE, "an axis's registers follow each other");

static const void *place(const struct source *source, uint8_t axis)
{
    return (const uint8_t *)source->at + CONFIG_INDEX(axis) * sizeof(struct axis);
}

static uint16_t word_of(const struct source *entry, uint8_t axis)
{
    struct source source = {.kind = SOURCE_CONSTANT};

    flash_copy(&source, entry, sizeof source);
    switch ((enum source_kind)source.kind) {
    case SOURCE_COUNTER:
        return *(const uint16_t *)((const uint8_t *)serial_counters() + source.constant);
    case SOURCE_BYTE:
        return *(const uint8_t *)place(&source, axis);
    case SOURCE_WORD:
        return *(const uint16_t *)place(&source, axis);
    case SOURCE_HIGH:
    case SOURCE_LOW:
        return half_word(*(const uint32_t *)place(&source, axis),
                         source.kind == SOURCE_LOW);
    case SOURCE_CALL_HIGH:
    case SOURCE_CALL_LOW:
        return source.call(axis, source.kind == SOURCE_CALL_LOW);
    case SOURCE_CONSTANT:
    default:
        return source.constant;
    }
}

uint16_t report_word(uint16_t address)
{
    if (address >= MORE_BASE) {
        return word_of(&more[address - MORE_BASE], 0);
    }
    if (address < REG_AXIS_BASE) {
        return word_of(&board[address], 0);
    }
    uint8_t offset = (uint8_t)(address - REG_AXIS_BASE);

    return word_of(&axes[offset % REG_AXIS_STRIDE],
                   CONFIG_INDEX(offset / REG_AXIS_STRIDE));
}
