// SPDX-License-Identifier: MIT
#include "app/settings/store.h"

#include "app/settings/settings.h" // settings_*
#include "config.h"                // FEATURE_STORE
#include "hal/eeprom.h"            // eeprom_*
#include "wire/crc16.h"            // crc16

#if FEATURE_STORE

#define SLOTS        2u
#define SLOT_STRIDE  64u
#define NO_SLOT      0xFFu
#define IDLE         0xFFu
#define RECORD_BYTES ((uint8_t)sizeof(struct settings))
_Static_assert(sizeof(struct settings) <= SLOT_STRIDE, "a record fits its slot");
_Static_assert(SLOTS *SLOT_STRIDE <= 256u, "a byte's address has eight bits");

#define STATE_FOUND   0x01u
#define STATE_CHANGED 0x02u
#define STATE_BUSY    0x04u

// Slot of the newest record, or NO_SLOT.
static uint8_t newest_slot;
// The first byte is erased first and written last, so that a record that is cut off by a power
// failure is invalid.
// Next byte of the record to write; RECORD_BYTES: the first one once more.
static uint8_t next_byte;
static uint8_t store_flags;

static uint16_t byte_address(uint8_t which, uint8_t byte)
{
    return (uint8_t)(which * SLOT_STRIDE + byte);
}

// Read a slot into the settings. Returns true when the record is whole and its settings are
// possible.
static bool load_record(uint8_t which)
{
    struct settings *record = settings_record();
    uint8_t *bytes = (uint8_t *)record;

    for (uint8_t i = 0; i < RECORD_BYTES; i++) {
        bytes[i] = eeprom_read(byte_address(which, i));
    }
    return record->version == SETTINGS_VERSION && record->bytes == RECORD_BYTES &&
           crc16(bytes, RECORD_BYTES) == 0 && settings_are_possible();
}

void store_load(void)
{
    uint16_t serial = 0;

    newest_slot = NO_SLOT;
    next_byte = IDLE;
    store_flags = STATE_FOUND;
    while (eeprom_busy()) {
    }
    for (uint8_t i = 0; i < SLOTS; i++) {
        if (load_record(i) &&
            (newest_slot == NO_SLOT || (int16_t)(settings_now()->serial - serial) > 0)) {
            newest_slot = i;
            serial = settings_now()->serial;
        }
    }
    if (newest_slot == NO_SLOT || !load_record(newest_slot)) {
        settings_set_defaults();
        settings_record()->serial = 0;
        store_flags = 0;
    }
}

void store_begin(void)
{
    struct settings *record = settings_record();

    record->version = SETTINGS_VERSION;
    record->bytes = RECORD_BYTES;
    record->serial++;
    record->checksum = crc16((const uint8_t *)record, RECORD_BYTES - sizeof(uint16_t));
    next_byte = 0;
}

bool store_busy(void)
{
    return next_byte != IDLE;
}

void store_poll(void)
{
    uint8_t older = newest_slot == 0 ? 1 : 0;

    if (next_byte == IDLE || eeprom_busy()) {
        return;
    }
    if (next_byte > RECORD_BYTES) {
        newest_slot = older;
        store_flags = STATE_FOUND;
        next_byte = IDLE;
        return;
    }
    uint8_t byte = next_byte == RECORD_BYTES ? 0 : next_byte;

    eeprom_write(byte_address(older, byte),
                 next_byte == 0 ? SETTINGS_ERASED
                                : ((const uint8_t *)settings_now())[byte]);
    next_byte++;
}

uint16_t store_state(void)
{
    return (uint16_t)(next_byte != IDLE ? store_flags | STATE_BUSY : store_flags);
}

void store_note_change(void)
{
    store_flags |= STATE_CHANGED;
}

#endif
