// SPDX-License-Identifier: MIT
#include "hal/eeprom.h"

#include <avr/io.h>
#include <util/atomic.h>

bool eeprom_busy(void)
{
    return (EECR & _BV(EEPE)) != 0;
}

uint8_t eeprom_read(uint16_t address)
{
    EEAR = address;
    EECR = (uint8_t)_BV(EERE);
    return EEDR;
}

void eeprom_write(uint16_t address, uint8_t byte)
{
    EEAR = address;
    EEDR = byte;
    // The part demands the second store within four cycles of the first.
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        EECR = (uint8_t)_BV(EEMPE);
        EECR |= (uint8_t)_BV(EEPE);
    }
}
