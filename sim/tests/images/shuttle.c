// SPDX-License-Identifier: MIT
// Axis 0 goes 20 steps up and 20 steps down, again and again, some 500 cycles a step.

#include <avr/io.h>
#include <util/delay_basic.h>

#define STEPS      20U
#define HALF_LOOPS 60U // of four cycles: half a step

#if defined(__AVR_ATmega2560__)
#define STEP_DDR  DDRB
#define STEP_PORT PORTB
#define STEP_BIT  6
#define DIR_DDR   DDRA
#define DIR_PORT  PORTA
#define DIR_BIT   0
#else
#define STEP_DDR  DDRB
#define STEP_PORT PORTB
#define STEP_BIT  2
#define DIR_DDR   DDRD
#define DIR_PORT  PORTD
#define DIR_BIT   4
#endif

static void go(void)
{
    for (uint8_t i = 0; i < STEPS; i++) {
        STEP_PORT |= (uint8_t)(1U << STEP_BIT);
        _delay_loop_2(HALF_LOOPS);
        STEP_PORT &= (uint8_t)~(1U << STEP_BIT);
        _delay_loop_2(HALF_LOOPS);
    }
}

int main(void)
{
    STEP_DDR |= (uint8_t)(1U << STEP_BIT);
    DIR_DDR |= (uint8_t)(1U << DIR_BIT);
    for (;;) {
        DIR_PORT &= (uint8_t)~(1U << DIR_BIT);
        go();
        DIR_PORT |= (uint8_t)(1U << DIR_BIT);
        go();
    }
}
