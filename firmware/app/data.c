// SPDX-License-Identifier: MIT
// The register map's contents: what the Modbus server reads and writes.
#include "app/machine.h"       // machine
#include "app/serial.h"        // serial_counters
#include "base/flash.h"        // IN_FLASH
#include "hal/cpu.h"           // cpu_reset_cause
#include "wire/bytes.h"        // get_word
#include "wire/register_map.h" // REG_*
#include "wire/server.h"       // data_*

#define STATUS_CLOCK   0x0001u
#define STATUS_ARMED   0x0002u
#define STATUS_RUNNING 0x0004u
#define STATUS_FAULT   0x0008u

static uint16_t status(void)
{
    uint16_t bits = machine_clock_present() ? STATUS_CLOCK : 0;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (machine_axis(i)->state == AXIS_ARMED) {
            bits |= STATUS_ARMED;
        } else if (machine_axis(i)->state == AXIS_RUNNING) {
            bits |= STATUS_RUNNING;
        }
    }
    return machine.fault.code != FAULT_none ? (uint16_t)(bits | STATUS_FAULT) : bits;
}

static uint16_t half(uint32_t value, bool low)
{
    return (uint16_t)(low ? value : value >> 16);
}

static uint16_t seek_register(uint16_t address)
{
    const struct seek *seek = &machine.seek;

    switch (address) {
    case REG_INPUT_inputs:
        return inputs_all();
    case REG_INPUT_trip_code:
        return seek->trip_code;
    case REG_INPUT_trip_axis:
        return seek->trip_axis;
    case REG_INPUT_trip_position_steps:
    case REG_INPUT_trip_position_steps + 1:
        return half((uint32_t)seek->position_steps,
                    address != REG_INPUT_trip_position_steps);
    case REG_INPUT_trip_ticks:
    case REG_INPUT_trip_ticks + 1:
        return half(seek->ticks, address != REG_INPUT_trip_ticks);
    default:
        return 0;
    }
}

static uint16_t limit_register(uint16_t address)
{
    switch (address) {
    case REG_INPUT_pixel_period_ticks:
    case REG_INPUT_pixel_period_ticks + 1:
        return half(machine.period.whole_ticks, address != REG_INPUT_pixel_period_ticks);
    case REG_INPUT_min_interval_ticks:
        return machine.limits.min_interval_ticks;
    case REG_INPUT_smooth_min_interval_ticks:
        return machine.limits.smooth_min_interval_ticks;
    case REG_INPUT_record_capacity:
        return LEDGER_RECORDS;
    default:
        return seek_register(address);
    }
}

static uint16_t board_register(uint16_t address)
{
    switch (address) {
    case REG_INPUT_map_version:
        return REG_MAP_VERSION;
    case REG_INPUT_firmware_version:
        return CONFIG_VERSION_MAJOR * 256u + CONFIG_VERSION_MINOR;
    case REG_INPUT_board_id:
        return CONFIG_BOARD_ID;
    case REG_INPUT_axis_count:
        return CONFIG_AXES;
    case REG_INPUT_status:
        return status();
    case REG_INPUT_reset_cause:
        return cpu_reset_cause();
    default:
        return limit_register(address);
    }
}

static uint16_t fault_register(uint16_t address)
{
    switch (address) {
    case REG_INPUT_fault_code:
        return machine.fault.code;
    case REG_INPUT_fault_argument:
        return machine.fault.argument;
    case REG_INPUT_fault_axis:
        return machine.fault.axis;
    case REG_INPUT_fault_pixel:
    case REG_INPUT_fault_pixel + 1:
        return half(machine.fault.pixel, address != REG_INPUT_fault_pixel);
    case REG_INPUT_fault_mask:
    case REG_INPUT_fault_mask_high:
        return half(machine.fault.mask, address == REG_INPUT_fault_mask);
    default:
        return board_register(address);
    }
}

static uint16_t counter_register(uint16_t address)
{
    switch (address) {
    case REG_INPUT_pixel_edges:
    case REG_INPUT_pixel_edges + 1:
        return half(machine.watch.edges, address != REG_INPUT_pixel_edges);
    case REG_INPUT_edge_error_ticks:
        return (uint16_t)machine.watch.error_ticks;
    case REG_INPUT_edge_error_max_ticks:
        return machine.watch.error_max_ticks;
    case REG_INPUT_frames_ok:
        return serial_counters()->frames_ok;
    case REG_INPUT_crc_errors:
        return serial_counters()->crc_errors;
    case REG_INPUT_exceptions:
        return serial_counters()->exceptions;
    case REG_INPUT_rx_overruns:
        return serial_counters()->rx_overruns;
    default:
        return fault_register(address);
    }
}

static int32_t expected_steps(const struct ledger *ledger)
{
    if (ledger->record_count == 0) {
        return 0;
    }
    uint8_t newest = ledger->record_next == 0 ? LEDGER_RECORDS : ledger->record_next;

    return ledger->records[newest - 1u].expected_steps;
}

static uint16_t axis_wide_register(const struct axis *axis, uint16_t offset)
{
    switch (offset) {
    case REG_AXIS_line_error_pixel:
    case REG_AXIS_line_error_pixel + 1:
        return half(axis->line_error_pixel, offset != REG_AXIS_line_error_pixel);
    case REG_AXIS_position_steps:
        // Now, as the first of the two words is read; the second belongs to it.
        (void)machine_follow((uint8_t)(axis - machine.axes));
        return half((uint32_t)ledger_position(&axis->ledger), false);
    case REG_AXIS_position_steps + 1:
        return half((uint32_t)ledger_position(&axis->ledger), true);
    case REG_AXIS_expected_steps:
    case REG_AXIS_expected_steps + 1:
        return half((uint32_t)expected_steps(&axis->ledger),
                    offset != REG_AXIS_expected_steps);
    case REG_AXIS_pixel:
    case REG_AXIS_pixel + 1:
    default:
        return half(axis->ledger.pixel, offset != REG_AXIS_pixel);
    }
}

static uint16_t axis_register(const struct axis *axis, uint16_t offset)
{
    switch (offset) {
    case REG_AXIS_axis_state:
        return axis->state;
    case REG_AXIS_queue_free:
        return run_queue_free(&axis->queue);
    case REG_AXIS_next_block:
        return axis->next_block;
    case REG_AXIS_line_error:
        return axis->line_error;
    case REG_AXIS_lines_done:
        return axis->lines_done;
    case REG_AXIS_underruns:
        return axis->underruns;
    case REG_AXIS_line_warning:
        return axis->line_warning;
    case REG_AXIS_ring_fill:
        return axis_ring_fill(axis);
    default:
        return axis_wide_register(axis, offset);
    }
}

static uint16_t record_word(const struct pixel_record *record, uint8_t word)
{
    switch (word) {
    case 0:
        return record->pixel;
    case 1:
    case 2:
        return half((uint32_t)record->expected_steps, word == 2);
    case 3:
    case 4:
        return half((uint32_t)record->actual_steps, word == 4);
    default:
        return (uint16_t)record->edge_error_ticks;
    }
}

static uint16_t record_register(const struct ledger *ledger, uint8_t offset)
{
    if (offset < 2) {
        return half(ledger->record_count == 0 ? 0 : ledger->pixel, offset == 1);
    }
    if (offset < REG_RECORD_HEADER) {
        return offset == 2 ? ledger->record_count : 0;
    }
    uint8_t behind_header = (uint8_t)(offset - REG_RECORD_HEADER);
    // A reply of records passes here for each of its words: the quotient by a product, right up to
    // 130. A sixth is 43/256 and a little less.
    _Static_assert(REG_RECORD_WORDS == 6 && REG_RECORD_STRIDE <= 130, "43/256 is 1/6");
    uint8_t number = (uint8_t)((uint16_t)behind_header * 43u >> 8);
    uint8_t word = (uint8_t)(behind_header - number * REG_RECORD_WORDS);

    if (number >= ledger->record_count) {
        return 0;
    }
    // Oldest first: the ring's next slot is the oldest once it is full.
    uint8_t slot = number;
    if (ledger->record_count == LEDGER_RECORDS) {
        slot = (uint8_t)(slot + ledger->record_next);
        slot = slot >= LEDGER_RECORDS ? (uint8_t)(slot - LEDGER_RECORDS) : slot;
    }
    return record_word(&ledger->records[slot], word);
}

#define AXIS_END   (REG_AXIS_BASE + CONFIG_AXES * REG_AXIS_STRIDE)
#define RECORD_END (REG_RECORD_BASE + CONFIG_AXES * REG_RECORD_STRIDE)

static bool inside(uint32_t first, uint32_t end, uint16_t low, uint16_t high)
{
    return first >= low && end <= high;
}

bool data_input_mapped(uint16_t address, uint16_t count)
{
    uint32_t end = (uint32_t)address + count;

    return inside(address, end, 0, REG_INPUT_trip_ticks + 2) ||
           inside(address, end, REG_AXIS_BASE, AXIS_END) ||
           inside(
               address, end, REG_INPUT_fault_mask_high, REG_INPUT_event_capacity + 1) ||
           inside(address, end, REG_RECORD_BASE, RECORD_END);
}

uint16_t data_input(uint16_t address)
{
    if (address >= REG_RECORD_BASE) {
        uint16_t offset = (uint16_t)(address - REG_RECORD_BASE);
        return record_register(
            &machine_axis((uint8_t)(offset / REG_RECORD_STRIDE))->ledger,
            (uint8_t)(offset % REG_RECORD_STRIDE));
    }
    if (address >= REG_AXIS_BASE && address < AXIS_END) {
        uint16_t offset = (uint16_t)(address - REG_AXIS_BASE);
        return axis_register(machine_axis((uint8_t)(offset / REG_AXIS_STRIDE)),
                             (uint16_t)(offset % REG_AXIS_STRIDE));
    }
    return counter_register(address);
}

bool data_holding_mapped(uint16_t address, uint16_t count)
{
    uint16_t word = 0;

    if (address >= REG_QUEUE_WINDOW) {
        return address == REG_QUEUE_WINDOW;
    }
    for (uint16_t i = 0; i < count; i++) {
        if (!settings_get(&machine.settings, (uint16_t)(address + i), &word)) {
            return false;
        }
    }
    return true;
}

uint16_t data_holding(uint16_t address)
{
    uint16_t word = 0;

    (void)settings_get(&machine.settings, address, &word);
    return word;
}

static enum modbus_exception queue_block(uint16_t count, const uint8_t *words)
{
    if (count < REG_QUEUE_HEADER + 2u || (count & 1u) != 0) {
        return MODBUS_ILLEGAL_VALUE;
    }
    uint16_t axis = get_word(&words[2]);
    if (axis >= CONFIG_AXES) {
        return MODBUS_ILLEGAL_VALUE;
    }
    switch (axis_queue_block(machine_axis((uint8_t)axis),
                             &machine.limits,
                             get_word(&words[0]),
                             &words[4],
                             (uint8_t)((count - REG_QUEUE_HEADER) / 2u))) {
    case BLOCK_TAKEN:
    case BLOCK_REPEATED:
        return MODBUS_OK;
    case BLOCK_FULL:
        return MODBUS_BUSY;
    case BLOCK_WRONG:
    case BLOCK_REFUSED:
    default:
        return MODBUS_ILLEGAL_VALUE;
    }
}

static enum modbus_exception commit(const struct settings *wanted,
                                    bool command,
                                    bool setting)
{
    struct pixel_period period;

    if (!settings_in_range(wanted) ||
        !pixel_period_set(
            &period, CONFIG_TIMER_HZ, wanted->pixel_hz_num, wanted->pixel_hz_den)) {
        return MODBUS_ILLEGAL_VALUE;
    }
    // Queued lines were checked against the settings of their time.
    if (setting && machine_queued()) {
        return MODBUS_BUSY;
    }
    if (command &&
        !machine_do((enum machine_command)wanted->command, (uint8_t)wanted->axis_mask)) {
        return MODBUS_DEVICE_FAILURE;
    }
    machine.settings = *wanted;
    if (setting) {
        // The reference is a line that is over, and its period may change.
        machine.watch.following = false;
        machine_apply_settings();
    }
    return MODBUS_OK;
}

// Not inline: what it keeps on the stack would lie below the check of a block.
static enum modbus_exception __attribute__((noinline)) write_settings(
    uint16_t address, uint16_t count, const uint8_t *words)
{
    struct settings wanted = machine.settings;
    uint16_t end = (uint16_t)(address + count);

    for (uint16_t i = 0; i < count; i++) {
        (void)settings_set(&wanted, (uint16_t)(address + i), get_word(&words[2u * i]));
    }
    return commit(&wanted, end > REG_HOLDING_command, address < REG_HOLDING_axis_mask);
}

enum modbus_exception data_write(uint16_t address, uint16_t count, const uint8_t *words)
{
    return address == REG_QUEUE_WINDOW ? queue_block(count, words)
                                       : write_settings(address, count, words);
}

uint8_t data_identity(uint8_t *text, uint8_t room)
{
#define TEXT_OF(value)             #value
#define VERSION_TEXT(major, minor) TEXT_OF(major) "." TEXT_OF(minor)
    static const char identity[] IN_FLASH =
        "pixstep " CONFIG_BOARD_NAME
        " " VERSION_TEXT(CONFIG_VERSION_MAJOR, CONFIG_VERSION_MINOR);
    uint8_t length = (uint8_t)(sizeof identity - 1u);

    if (length > room) {
        length = room;
    }
    for (uint8_t i = 0; i < length; i++) {
        text[i] = (uint8_t)flash_char(&identity[i]);
    }
    return length;
}

bool data_running(void)
{
    return (status() & STATUS_RUNNING) != 0;
}

uint8_t data_server_id(void)
{
    return CONFIG_BOARD_ID;
}
