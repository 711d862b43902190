// SPDX-License-Identifier: MIT
// Settings that outlive the supply: two records in the EEPROM, of which the newer whole one counts.
// Only the older record is ever written. Its first byte identifies a record: this byte is erased
// before anything else is changed, and is written last.
//
//     slot 0   | 1 | 42 | 7 | words | crc |    whole, number 7
//     slot 1   |FF | 42 | 8 | wor...           number 8 is being written: not a record yet
//
// A supply that fails at any moment therefore leaves the old settings or the new ones. Main loop
// only.
//
//     store_begin()   store_poll(), a byte for each call that finds the EEPROM ready
//     |               |erase 1st|2nd|3rd| ... |last|write 1st|
//     store_busy() ___/~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~~\___
//
// An image without FEATURE_STORE begins with the defaults after each reset.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "app/settings/settings.h" // settings_set_defaults
#include "config.h"                // FEATURE_STORE

#if FEATURE_STORE

// Load the newest whole record whose values are possible, else the defaults. Called once at reset;
// waits for a write that the reset interrupted.
void store_load(void);

// Begin to store the settings in use, in the slot of the older record. The settings must not change
// until store_busy() is false: commands.c and data.c refuse a change meanwhile. Only when
// store_busy() is false.
void store_begin(void);
// True from store_begin() until the last byte of the record is written.
bool store_busy(void);

// Write the next byte when the memory is ready; never waits. Once a round.
void store_poll(void);

// Input register settings_state: bit 0 a record was found or stored, bit 1 the settings may differ
// from that record, bit 2 a record is being written.
uint16_t store_state(void);

// Note that the settings in use may differ from the stored record. Only while store_busy() is
// false, because the end of a record clears the note.
void store_note_change(void);

#else

// Without FEATURE_STORE nothing is stored, and every reset begins with the defaults.
static inline void store_load(void)
{
    settings_set_defaults();
}

static inline bool store_busy(void)
{
    return false;
}

static inline void store_poll(void)
{
}

static inline uint16_t store_state(void)
{
    return 0;
}

static inline void store_note_change(void)
{
}

#endif
