// SPDX-License-Identifier: MIT
// Settings that outlive the supply: two records in the EEPROM, the newer whole one counts. Only the
// older one is ever written, and its first byte, by which a record is known, is taken away before
// anything else is changed and comes last:
//
//     slot 0   | 1 | 42 | 7 | words | crc |    whole, number 7
//     slot 1   |FF | 42 | 8 | wor...           number 8 is being written: not a record yet
//
// So a supply that fails at any moment leaves the old settings or the new ones. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "app/settings.h" // settings_set_defaults
#include "config.h"       // FEATURE_STORE

#if FEATURE_STORE

// The settings from the newest whole record whose values are possible, else the defaults.
void store_load(void);

// Begin to store the settings, which must not change until it is done.
void store_begin(void);
bool store_busy(void);

// A byte further, when the memory is ready for one.
void store_poll(void);

// Input register settings_state.
uint16_t store_state(void);

// The settings are others than what is stored.
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
