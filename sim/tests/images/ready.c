// SPDX-License-Identifier: MIT
// A byte of the EEPROM whose end nobody waits for: EE_READY says when it is there. Expected values
// in test_eeprom.py.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

ISR(EE_READY_vect)
{
    EECR = 0;
    RESULT[0] = TCNT1;
    RESULT[1]++;
}

int main(void)
{
    RESULT[1] = 0;
    TCCR1B = (uint8_t)(1U << CS10);
    EEAR = 7;
    EEDR = 0xA5;
    EECR = (uint8_t)(1U << EEMPE);
    EECR |= (uint8_t)(1U << EEPE);
    EECR |= (uint8_t)(1U << EERIE);
    sei();
    for (;;) {
    }
}
