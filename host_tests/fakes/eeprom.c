// SPDX-License-Identifier: MIT
#include "fakes/eeprom.h"

#include <string.h>

#include "hal/eeprom.h"

uint8_t fake_eeprom[FAKE_EEPROM_BYTES];
uint8_t fake_eeprom_busy_looks;
uint16_t fake_eeprom_writes;
uint16_t fake_eeprom_last;
static uint8_t busy_left;

void fake_eeprom_reset(void)
{
    memset(fake_eeprom, 0xFF, sizeof fake_eeprom);
    fake_eeprom_busy_looks = 2;
    fake_eeprom_writes = 0;
    busy_left = 0;
}

bool eeprom_busy(void)
{
    if (busy_left != 0) {
        busy_left--;
        return true;
    }
    return false;
}

uint8_t eeprom_read(uint16_t address)
{
    return fake_eeprom[address];
}

void eeprom_write(uint16_t address, uint8_t byte)
{
    fake_eeprom[address] = byte;
    fake_eeprom_last = address;
    fake_eeprom_writes++;
    busy_left = fake_eeprom_busy_looks;
}
