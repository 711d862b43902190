// SPDX-License-Identifier: MIT
// The register map's contents: what the Modbus server reads and writes.
#include "app/events.h"        // events_*
#include "app/machine.h"       // machine
#include "app/report.h"        // report_*
#include "app/store.h"         // store_busy
#include "base/apart.h"        // APART
#include "base/flash.h"        // IN_FLASH
#include "wire/bytes.h"        // get_word, half_word
#include "wire/register_map.h" // REG_*
#include "wire/server.h"       // data_*

static APART uint16_t record_word(const struct pixel_record *record, uint8_t word)
{
    switch (word) {
    case 0:
        return record->pixel;
    case 1:
    case 2:
        return half_word((uint32_t)record->expected_steps, word == 2);
    case 3:
    case 4:
        return half_word((uint32_t)record->actual_steps, word == 4);
    default:
        return (uint16_t)record->edge_error_ticks;
    }
}

static uint16_t record_register(const struct ledger *ledger, uint8_t offset)
{
    if (offset < 2) {
        return half_word(ledger->record_count == 0 ? 0 : ledger->pixel, offset == 1);
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

// The input registers that there are, in order.
static const struct area {
    uint16_t first;
    uint16_t end;
} input_areas[] IN_FLASH = {
    {0, REG_AXIS_BASE + CONFIG_AXES * REG_AXIS_STRIDE},
    {REG_INPUT_fault_mask_high, REG_INPUT_event_capacity + 1u},
    {REG_RECORD_BASE, REG_RECORD_BASE + CONFIG_AXES * REG_RECORD_STRIDE},
#if CONFIG_EVENTS != 0
    {REG_EVENT_BASE, REG_EVENT_BASE + REG_EVENT_HEADER + CONFIG_EVENTS * REG_EVENT_WORDS},
#endif
};

#define INPUT_AREAS ((uint8_t)(sizeof input_areas / sizeof input_areas[0]))

// A read may go on from one area to the next where they touch.
bool data_input_mapped(uint16_t address, uint16_t count)
{
    for (uint8_t i = 0; i < INPUT_AREAS; i++) {
        uint16_t end = flash_word(&input_areas[i].end);
        uint16_t room = (uint16_t)(end - address);
        if (address >= flash_word(&input_areas[i].first) && address < end) {
            if (count <= room) {
                return true;
            }
            count = (uint16_t)(count - room);
            address = end;
        }
    }
    return false;
}

uint16_t data_input(uint16_t address)
{
    if (address < REG_RECORD_BASE) {
        return report_word(address);
    }
    if (CONFIG_EVENTS != 0 && address >= REG_EVENT_BASE) {
        return events_word(address);
    }
    uint16_t offset = (uint16_t)(address - REG_RECORD_BASE);

    return record_register(
        &machine_axis(CONFIG_INDEX(offset / REG_RECORD_STRIDE))->ledger,
        (uint8_t)(offset % REG_RECORD_STRIDE));
}

// The word itself; NULL when nothing is mapped there.
static APART uint16_t *holding(uint16_t address)
{
    if (address < SETTINGS_WORDS) {
        return &machine.settings.words[address];
    }
    address = (uint16_t)(address - REG_HOLDING_axis_mask);
    return address < MACHINE_ORDER_WORDS ? &machine.order[address] : NULL;
}

bool data_holding_mapped(uint16_t address, uint16_t count)
{
    if (address >= REG_QUEUE_WINDOW) {
        return address == REG_QUEUE_WINDOW;
    }
    return holding(address) != NULL &&
           holding((uint16_t)(address + count - 1u)) != NULL && count <= SETTINGS_WORDS;
}

uint16_t data_holding(uint16_t address)
{
    const uint16_t *word = holding(address);

    return word != NULL ? *word : 0;
}

static enum modbus_exception queue_block(uint16_t count, const uint8_t *words)
{
    uint16_t axis = get_word(&words[2]);
    if (count < REG_QUEUE_HEADER + 2u || (count & 1u) != 0 || axis >= CONFIG_AXES) {
        return MODBUS_ILLEGAL_VALUE;
    }
    // What is queued will be forgotten when the axis rests.
    if ((machine.stopping & axis_bit((uint8_t)axis)) != 0) {
        return MODBUS_BUSY;
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

// Not inline: what it keeps on the stack would lie below the check of a block.
static APART enum modbus_exception write_settings(uint8_t address,
                                                  uint8_t count,
                                                  const uint8_t *words)
{
    struct settings before = machine.settings;

    for (uint8_t i = 0; i < count; i++) {
        machine.settings.words[(uint8_t)(address + i)] = get_word(&words[2u * i]);
    }
    bool possible = settings_possible(&machine.settings);
    // Queued lines were checked against the settings of their time.
    if (!possible || machine_queued() || store_busy()) {
        machine.settings = before;
        return possible ? MODBUS_BUSY : MODBUS_ILLEGAL_VALUE;
    }
    store_note_change();
    machine_apply_settings();
    return MODBUS_OK;
}

// Mask, command and argument: what is left out keeps its value, the argument is none.
static enum modbus_exception give_order(uint8_t address,
                                        uint8_t count,
                                        const uint8_t *words)
{
    uint16_t order[MACHINE_ORDER_WORDS] = {machine.order[0], COMMAND_NONE, 0};

    for (uint8_t i = 0; i < count; i++) {
        order[address + i] = get_word(&words[2u * i]);
    }
    if (order[0] > MACHINE_MASK_MAX || order[1] > COMMAND_LAST) {
        return MODBUS_ILLEGAL_VALUE;
    }
    uint16_t argument = machine.order[2];
    machine.order[2] = order[2];
    if (!machine_do((enum machine_command)order[1], (uint8_t)order[0])) {
        machine.order[2] = argument;
        return MODBUS_DEVICE_FAILURE;
    }
    machine.order[0] = order[0];
    machine.order[1] = order[1];
    return MODBUS_OK;
}

enum modbus_exception data_write(uint16_t address, uint16_t count, const uint8_t *words)
{
    if (address == REG_QUEUE_WINDOW) {
        return queue_block(count, words);
    }
    if (address >= REG_HOLDING_axis_mask) {
        return give_order(
            (uint8_t)(address - REG_HOLDING_axis_mask), (uint8_t)count, words);
    }
    return write_settings((uint8_t)address, (uint8_t)count, words);
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
    return (report_status() & REPORT_RUNNING) != 0;
}

uint8_t data_server_id(void)
{
    return CONFIG_BOARD_ID;
}
