// SPDX-License-Identifier: MIT
// Lets the watchdog reset the part once: RESULT[0] = 2 then, RESULT[1] = GPIOR2 as the reset left
// it, RESULT[2] = TCCR1B; and timer 1 steps from then on, 1000 ticks a period.

#include <avr/io.h>
#include <avr/wdt.h>

#include "result.h"

static void step_on(void)
{
#if defined(__AVR_ATmega2560__)
    DDRB = (uint8_t)(1U << 6);
#else
    DDRB = (uint8_t)(1U << 2);
#endif
    OCR1A = 999;
    OCR1B = 31;
    TCCR1A = (uint8_t)((1U << COM1B1) | (1U << COM1B0) | (1U << WGM11) | (1U << WGM10));
    TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10));
}

int main(void)
{
    uint8_t cause = MCUSR;

    MCUSR = 0;
    wdt_disable();
    if ((cause & (1U << WDRF)) != 0) {
        RESULT[0] = 2;
        RESULT[1] = GPIOR2;
        RESULT[2] = TCCR1B;
    } else {
        RESULT[0] = 1;
        GPIOR2 = 0x77;
        wdt_enable(WDTO_15MS);
    }
    step_on();
    for (;;) {
    }
}
