// SPDX-License-Identifier: MIT
#include "app/store.h"

#include "app/machine.h" // machine.settings
#include "app/settings.h"
#include "hal/eeprom.h" // eeprom_*
#include "wire/crc16.h" // crc16

#define SLOTS        2u
#define SLOT_STRIDE  64u
#define NO_SLOT      0xFFu
#define IDLE         0xFFu
#define RECORD       ((uint8_t *)&machine.settings)
#define RECORD_BYTES ((uint8_t)sizeof(struct settings))
_Static_assert(sizeof(struct settings) <= SLOT_STRIDE, "a record fits its slot");

#define STATE_FOUND   0x01u
#define STATE_CHANGED 0x02u
#define STATE_BUSY    0x04u

static uint8_t newest = NO_SLOT; // of the newest record
static uint8_t to_write =
    IDLE; // byte to write; the record's size: its first one once more
static uint8_t flags;

static uint16_t place(uint8_t which, uint8_t byte)
{
    return (uint16_t)(which * SLOT_STRIDE + byte);
}

static bool load(uint8_t which)
{
    for (uint8_t i = 0; i < RECORD_BYTES; i++) {
        RECORD[i] = eeprom_read(place(which, i));
    }
    return machine.settings.version == SETTINGS_VERSION &&
           machine.settings.bytes == RECORD_BYTES && crc16(RECORD, RECORD_BYTES) == 0 &&
           settings_possible(&machine.settings);
}

void store_load(void)
{
    uint16_t serial = 0;

    newest = NO_SLOT;
    to_write = IDLE;
    flags = STATE_FOUND;
    while (eeprom_busy()) {
    }
    for (uint8_t i = 0; i < SLOTS; i++) {
        if (load(i) &&
            (newest == NO_SLOT || (int16_t)(machine.settings.serial - serial) > 0)) {
            newest = i;
            serial = machine.settings.serial;
        }
    }
    if (newest == NO_SLOT || !load(newest)) {
        settings_defaults(&machine.settings);
        machine.settings.serial = 0;
        flags = 0;
    }
}

void store_begin(void)
{
    machine.settings.version = SETTINGS_VERSION;
    machine.settings.bytes = RECORD_BYTES;
    machine.settings.serial++;
    machine.settings.checksum = crc16(RECORD, RECORD_BYTES - sizeof(uint16_t));
    to_write = 0;
}

bool store_busy(void)
{
    return to_write != IDLE;
}

void store_poll(void)
{
    uint8_t older = newest == 0 ? 1 : 0;

    if (to_write == IDLE || eeprom_busy()) {
        return;
    }
    if (to_write > RECORD_BYTES) {
        newest = older;
        flags = STATE_FOUND;
        to_write = IDLE;
        return;
    }
    uint8_t byte = to_write == RECORD_BYTES ? 0 : to_write;

    eeprom_write(place(older, byte), to_write == 0 ? SETTINGS_ERASED : RECORD[byte]);
    to_write++;
}

uint16_t store_state(void)
{
    return (uint16_t)(to_write != IDLE ? flags | STATE_BUSY : flags);
}

void store_note_change(void)
{
    flags |= STATE_CHANGED;
}
