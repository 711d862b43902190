// SPDX-License-Identifier: MIT
// Mode 15 on timer 1 as the step generator uses it: periods of 400, 401, ... 499 ticks with
// pulses, then eight quiet ones, then eight with OCR1B = TOP (which must not pulse), then 600
// ticks for ever.

#include <avr/interrupt.h>
#include <avr/io.h>

#define FIRST_TICKS 400U
#define LAST_TICKS  500U
#define COMPARE     31U
#define QUIET       0xFFFFU

static uint16_t ticks = FIRST_TICKS;

// One call a period: loads the one after the next BOTTOM.
ISR(TIMER1_OVF_vect)
{
    ticks++;
    if (ticks < LAST_TICKS) {
        OCR1A = ticks - 1U;
    } else if (ticks < LAST_TICKS + 8U) {
        OCR1A = 999U;
        OCR1B = QUIET;
    } else if (ticks < LAST_TICKS + 16U) {
        OCR1A = 799U;
        OCR1B = 799U;
    } else {
        OCR1A = 599U;
        OCR1B = COMPARE;
        ticks = LAST_TICKS + 16U;
    }
}

int main(void)
{
#if defined(__AVR_ATmega2560__)
    DDRB = (uint8_t)(1U << 6);
#else
    DDRB = (uint8_t)(1U << 2);
#endif
    OCR1A = FIRST_TICKS - 1U; // in mode 0: loaded at once
    OCR1B = COMPARE;
    TCCR1A = (uint8_t)((1U << COM1B1) | (1U << COM1B0) | (1U << WGM11) | (1U << WGM10));
    TIMSK1 = (uint8_t)(1U << TOIE1);
    TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10));
    sei();
    for (;;) {
    }
}
