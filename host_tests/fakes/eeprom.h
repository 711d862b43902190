// SPDX-License-Identifier: MIT
// Memory that keeps its bytes, as an array.
#pragma once

#include <stdint.h>

#define FAKE_EEPROM_BYTES 128u

extern uint8_t fake_eeprom[FAKE_EEPROM_BYTES];
extern uint8_t fake_eeprom_busy_looks; // how often it says busy after a write
extern uint16_t fake_eeprom_writes;    // since the reset
extern uint16_t fake_eeprom_last;      // address of the last one

void fake_eeprom_reset(void); // erased
