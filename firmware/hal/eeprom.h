// SPDX-License-Identifier: MIT
// Memory that keeps its bytes without power. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// A byte is being written: 3.4 ms. Until then nothing may be read or written.
bool eeprom_busy(void);

uint8_t eeprom_read(uint16_t address);

// Starts. A supply that fails meanwhile leaves this byte, and no other, with any value.
void eeprom_write(uint16_t address, uint8_t byte);
