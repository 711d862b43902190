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
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "app/settings.h" // settings_set_defaults
#include "config.h"       // FEATURE_STORE

#if FEATURE_STORE

// Load the newest whole record whose values are possible, else the defaults.
void store_load(void);

// Begin to store the settings, which must not change until the store is finished.
void store_begin(void);
// A record is being written.
bool store_busy(void);

// Write the next byte when the memory is ready. Once a round.
void store_poll(void);

// Input register settings_state.
uint16_t store_state(void);

// The settings differ from the stored record.
void store_note_change(void);

#else

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
