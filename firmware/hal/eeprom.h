// SPDX-License-Identifier: MIT
// Memory that keeps its bytes without a supply. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// A byte is being written, which takes 3.4 ms. Until then nothing may be read or written.
bool eeprom_busy(void);

// The byte at this address.
uint8_t eeprom_read(uint16_t address);

// Begin to write a byte. If the supply fails meanwhile, this byte, and no other, has any value.
void eeprom_write(uint16_t address, uint8_t byte);
