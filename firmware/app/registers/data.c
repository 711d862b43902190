// SPDX-License-Identifier: MIT
// The register map's contents: what the Modbus server reads and writes.
#include "app/axes/axes.h"          // axes_get
#include "app/axes/events.h"        // events_word, events_words
#include "app/axes/limits.h"        // limits_*
#include "app/registers/commands.h" // commands_*
#include "app/registers/report.h"   // report_word, report_words
#include "app/settings/settings.h"  // settings_*
#include "app/settings/store.h"     // store_*
#include "base/apart.h"             // APART
#include "base/flash.h"             // IN_FLASH
#include "base/interlude.h"         // interlude
#include "wire/bytes.h"             // get_word, half_word
#include "wire/register_map.h"      // REG_*
#include "wire/server_data.h"       // data_*

// Behind the last record that is kept.
#define RECORDS_END (REG_RECORD_HEADER + RECORDS_KEPT * REG_RECORD_WORDS)

static uint16_t record_register(const struct ledger *ledger, uint8_t offset)
{
    if (offset >= RECORDS_END) {
        return 0;
    }
    BY_POINTER_SMALL(ledger);
    uint8_t count = records_shown(&ledger->records);

    if (offset < 2) {
        return half_word(ledger->records.count == 0 ? 0 : ledger->pixel, offset == 1);
    }
    if (offset < REG_RECORD_HEADER) {
        return offset == 2 ? count : ledger->records.made;
    }
    uint8_t behind_header = (uint8_t)(offset - REG_RECORD_HEADER);
    // A reply of records passes here for each of its words: the quotient by a product, right up to
    // 130. A sixth is 43/256 and a little less.
    _Static_assert(REG_RECORD_WORDS == 6 && REG_RECORD_STRIDE <= 130, "43/256 is 1/6");
    uint8_t number = (uint8_t)((uint16_t)behind_header * 43u >> 8);
    uint8_t word = (uint8_t)(behind_header - number * REG_RECORD_WORDS);

    if (number >= count) {
        return 0;
    }
    return records_word(&ledger->records, number, word);
}

// Registers that follow each other.
struct area {
    uint16_t first;
    uint16_t end;
};

// The input registers that there are, in order.
static const struct area input_areas[] IN_FLASH = {
    {0, REG_AXIS_BASE + CONFIG_AXES * REG_AXIS_STRIDE},
    {REG_INPUT_fault_mask_high, REG_INPUT_features_high + 1u},
    {REG_ROOM_BASE, REG_ROOM_BASE + CONFIG_AXES},
    {REG_RECORD_BASE, REG_RECORD_BASE + CONFIG_AXES * REG_RECORD_STRIDE},
#if FEATURE_EVENTS
    {REG_EVENT_BASE, REG_EVENT_BASE + REG_EVENT_HEADER + CONFIG_EVENTS * REG_EVENT_WORDS},
#endif
};

#define ORDER_WORDS (sizeof(struct order) / sizeof(uint16_t))

// The holding registers that there are, but for the queue window.
static const struct area holding_areas[] IN_FLASH = {
    {0, SETTINGS_WORDS},
    {REG_HOLDING_axis_mask, REG_HOLDING_axis_mask + ORDER_WORDS},
};

#define AREAS(areas) ((uint8_t)(sizeof(areas) / sizeof(areas)[0]))

// True when these areas have all of the registers. A read may go on from one area to the next where
// they touch.
static APART bool are_mapped(const struct area *area,
                             uint8_t areas,
                             uint16_t address,
                             uint16_t count)
{
    for (; areas != 0; areas--) {
        uint16_t first = flash_word(&area->first);
        uint16_t end = flash_word(&area->end);
        uint16_t room = (uint16_t)(end - address);

        area++;
        if (address >= first && address < end) {
            if (count <= room) {
                return true;
            }
            count = (uint16_t)(count - room);
            address = end;
        }
    }
    return false;
}

bool data_input_mapped(uint16_t address, uint16_t count)
{
    return are_mapped(input_areas, AREAS(input_areas), address, count);
}

APART uint16_t data_input(uint16_t address)
{
    if (address < REG_ROOM_BASE) {
        return report_word(address);
    }
    if (address < REG_RECORD_BASE) {
        return segment_queue_free(
            &axes_get(CONFIG_INDEX((uint8_t)(address - REG_ROOM_BASE)))->queue);
    }
    if (FEATURE_EVENTS && address >= REG_EVENT_BASE) {
        return events_word(address);
    }
    uint16_t offset = (uint16_t)(address - REG_RECORD_BASE);

    return record_register(&axes_get(CONFIG_INDEX(offset / REG_RECORD_STRIDE))->ledger,
                           (uint8_t)(offset % REG_RECORD_STRIDE));
}

#if SEVERAL_AXES
// Records that there is room for in the registers of an axis.
#define RECORDS_MAPPED ((REG_RECORD_STRIDE - REG_RECORD_HEADER) / REG_RECORD_WORDS)

// Whole records of an axis.
static inline uint8_t record_words(uint16_t offset, uint8_t count, uint8_t *to)
{
    const struct records *records =
        &axes_get(CONFIG_INDEX(offset / REG_RECORD_STRIDE))->ledger.records;
    uint8_t place = (uint8_t)(offset % REG_RECORD_STRIDE);
    uint8_t behind_header = (uint8_t)(place - REG_RECORD_HEADER);
    uint8_t number = behind_header / REG_RECORD_WORDS;
    uint8_t wanted = count / REG_RECORD_WORDS;

    // Not between a header and its records, which it counts. Twenty records take 2,000 cycles.
    if (place == 0) {
        interlude();
    }
    if (place < REG_RECORD_HEADER || behind_header % REG_RECORD_WORDS != 0 ||
        number >= RECORDS_MAPPED) {
        return 0;
    }
    if (number != 0) {
        interlude();
    }
    if (wanted > RECORDS_MAPPED - number) {
        wanted = (uint8_t)(RECORDS_MAPPED - number);
    }
    records_write(records, number, wanted, to);
    return (uint8_t)(wanted * REG_RECORD_WORDS);
}

APART uint8_t data_inputs(uint16_t address, uint8_t count, uint8_t *to)
{
    if (address < REG_ROOM_BASE) {
        return report_words(address, count, to);
    }
    if (address < REG_RECORD_BASE) {
        return 0;
    }
    if (FEATURE_EVENTS && address >= REG_EVENT_BASE) {
        return events_words(address, count, to);
    }
    return record_words((uint16_t)(address - REG_RECORD_BASE), count, to);
}
#endif

// The word itself; NULL when nothing is mapped there.
static APART const uint16_t *holding_word(uint16_t address)
{
    if (address < SETTINGS_WORDS) {
        return &settings_now()->words[address];
    }
    address = (uint16_t)(address - REG_HOLDING_axis_mask);
    return address < ORDER_WORDS ? &commands_last()->mask + address : NULL;
}

bool data_holding_mapped(uint16_t address, uint16_t count)
{
    return address == REG_QUEUE_WINDOW ||
           are_mapped(holding_areas, AREAS(holding_areas), address, count);
}

uint16_t data_holding(uint16_t address)
{
    const uint16_t *word = holding_word(address);

    return word != NULL ? *word : 0;
}

// The window's words behind its header are runs of two words, or, when the axis's word has a number
// of bytes in its high half, that many bytes of packed entries.
static bool read_block(struct block *block, uint16_t count, uint8_t *words)
{
    uint8_t bytes = words[2];
    uint8_t room = (uint8_t)(2u * (count - REG_QUEUE_HEADER));

    block->number = get_word(words);
    block->bytes = &words[2u * REG_QUEUE_HEADER];
    block->packed = bytes != 0;
    block->size = bytes != 0 ? bytes : room;
    if (count <= REG_QUEUE_HEADER || words[3] >= CONFIG_AXES) {
        return false;
    }
    return bytes != 0 ? (uint8_t)(room - bytes) < 2u : room % 4u == 0;
}

// Settings that were just written may come into force: now, and they are possible.
static APART_LARGE enum modbus_exception judge_settings(void)
{
    // Queued lines were checked against the settings of their time. While an axis moves, no time
    // goes into the settings themselves.
    if (axes_any_queued() || store_busy()) {
        return MODBUS_BUSY;
    }
    return settings_are_possible() ? MODBUS_OK : MODBUS_ILLEGAL_VALUE;
}

static APART void apply_settings(void)
{
    store_note_change();
    limits_apply_settings();
}

#if FEATURE_LINE_DIVIDER
// Let a line's divider be the setting while its block is checked; settle_divider() must follow.
static APART void try_divider(const struct axis *axis, const struct block *block)
{
    uint16_t *divider = &settings_record()->divider;
    uint16_t before = *divider;
    uint16_t edges = axis_block_divider(axis, block);

    if (edges == 0 || edges == before) {
        return;
    }
    *divider = edges;
    if (judge_settings() == MODBUS_OK) {
        limits_try_settings();
    } else {
        *divider = before;
    }
}
#endif

// The divider of a line counts from the block on that brings it, if that is taken.
static inline void settle_divider(uint16_t before, bool taken)
{
    if (!FEATURE_LINE_DIVIDER || settings_now()->divider == before) {
        return;
    }
    if (taken) {
        apply_settings();
    } else {
        settings_record()->divider = before;
        limits_try_settings();
    }
}

// The blocks of a queue and the orders are not inlined: what one of them keeps on the stack would
// lie below the other.
static APART enum modbus_exception queue_block(uint16_t count, uint8_t *words)
{
    struct block block;
    uint16_t divider = settings_now()->divider;

    if (!read_block(&block, count, words)) {
        return MODBUS_ILLEGAL_VALUE;
    }
#if FEATURE_LINE_DIVIDER
    try_divider(axes_get(words[3]), &block);
#endif
    enum block_result result =
        axis_queue_block(axes_get(words[3]), limits_of(words[3]), &block);

    settle_divider(divider, result == BLOCK_TAKEN);
    switch (result) {
    case BLOCK_TAKEN:
    case BLOCK_REPEATED:
        return MODBUS_OK;
    case BLOCK_FULL:
        return MODBUS_BUSY;
    case BLOCK_REFUSED:
    case BLOCK_WRONG:
    default:
        return MODBUS_ILLEGAL_VALUE;
    }
}

static APART_LARGE enum modbus_exception write_settings(uint8_t address,
                                                        uint8_t count,
                                                        uint8_t *words)
{
    settings_exchange(address, count, words);
    enum modbus_exception result = judge_settings();
    if (result == MODBUS_OK) {
        apply_settings();
    } else {
        settings_exchange(address, count, words);
    }
    return result;
}

// Mask, command, argument, edge and tag: a mask or a tag that is left out keeps its value, the rest
// is none.
static APART enum modbus_exception write_order(uint8_t first,
                                               uint8_t count,
                                               const uint8_t *words)
{
    struct order order = {.mask = commands_last()->mask, .tag = commands_last()->tag};
    uint16_t *word = &order.mask + first; // its words lie as the registers do

    for (; count != 0; count--) {
        // The server has checked that the range ends with the tag, the last of five words.
        *word = get_word(words); // NOLINT(clang-analyzer-security.ArrayBound)
        word++;
        words += 2;
    }
    if (order.mask > COMMANDS_MASK_MAX || order.command > COMMAND_LAST) {
        return MODBUS_ILLEGAL_VALUE;
    }
    return commands_give(&order) ? MODBUS_OK : MODBUS_DEVICE_FAILURE;
}

enum modbus_exception data_write(uint16_t address, uint16_t count, uint8_t *words)
{
    if (address == REG_QUEUE_WINDOW) {
        return queue_block(count, words);
    }
    if (address >= REG_HOLDING_axis_mask) {
        return write_order(
            (uint8_t)(address - REG_HOLDING_axis_mask), (uint8_t)count, words);
    }
    return write_settings((uint8_t)address, (uint8_t)count, words);
}
