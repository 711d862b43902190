// SPDX-License-Identifier: MIT
// STEP and DIR of axis 0 by plain port writes: 5 steps up, 9 down, 3 up, then rest.

#include <avr/io.h>

#if defined(__AVR_ATmega2560__)
#define STEP_BIT ((uint8_t)(1U << 6)) // PB6
#define DIR_DDR  DDRA
#define DIR_PORT PORTA
#define DIR_BIT  ((uint8_t)(1U << 0)) // PA0
#else
#define STEP_BIT ((uint8_t)(1U << 2)) // PB2
#define DIR_DDR  DDRD
#define DIR_PORT PORTD
#define DIR_BIT  ((uint8_t)(1U << 4)) // PD4
#endif

static void steps(uint8_t count)
{
    while (count-- != 0) {
        PORTB |= STEP_BIT;
        PORTB &= (uint8_t)~STEP_BIT;
    }
}

int main(void)
{
    DDRB |= STEP_BIT;
    DIR_DDR |= DIR_BIT;
    steps(5);
    DIR_PORT |= DIR_BIT;
    steps(9);
    DIR_PORT &= (uint8_t)~DIR_BIT;
    steps(3);
    for (;;) {
    }
}
