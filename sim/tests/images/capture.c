// SPDX-License-Identifier: MIT
// Input capture in mode 15, TOP = 9999: a STEP edge every period (so that the test knows BOTTOM),
// and every captured count in RESULT[1...]. RESULT[0] counts them; TOV1 pending at the capture in
// bit 15.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

#define TOP_TICKS 9999U
#define RESULTS   60U

#if defined(__AVR_ATmega2560__)
ISR(TIMER5_CAPT_vect)
{
    uint16_t at = RESULT[0];

    if (at < RESULTS) {
        RESULT[0] = at + 1U;
        RESULT[1U + at] = ICR5;
    }
}

static void start(void)
{
    DDRL = (uint8_t)(1U << 4);
    OCR5A = TOP_TICKS;
    OCR5B = 31;
    TCCR5A = (uint8_t)((1U << COM5B1) | (1U << COM5B0) | (1U << WGM51) | (1U << WGM50));
    TIMSK5 = (uint8_t)(1U << ICIE5);
    TCCR5B = (uint8_t)((1U << ICES5) | (1U << WGM53) | (1U << WGM52) | (1U << CS50));
}
#elif defined(__AVR_ATmega1284P__)
ISR(TIMER3_CAPT_vect)
{
    uint16_t at = RESULT[0];

    if (at < RESULTS) {
        RESULT[0] = at + 1U;
        RESULT[1U + at] = ICR3;
    }
}

static void start(void)
{
    DDRB = (uint8_t)(1U << 7);
    OCR3A = TOP_TICKS;
    OCR3B = 31;
    TCCR3A = (uint8_t)((1U << COM3B1) | (1U << COM3B0) | (1U << WGM31) | (1U << WGM30));
    TIMSK3 = (uint8_t)(1U << ICIE3);
    TCCR3B = (uint8_t)((1U << ICES3) | (1U << WGM33) | (1U << WGM32) | (1U << CS30));
}
#else
ISR(TIMER1_CAPT_vect)
{
    uint16_t at = RESULT[0];

    if (at < RESULTS) {
        RESULT[0] = at + 1U;
        RESULT[1U + at] = ICR1;
    }
}

static void start(void)
{
    DDRB = (uint8_t)(1U << 2);
    OCR1A = TOP_TICKS;
    OCR1B = 31;
    TCCR1A = (uint8_t)((1U << COM1B1) | (1U << COM1B0) | (1U << WGM11) | (1U << WGM10));
    TIMSK1 = (uint8_t)(1U << ICIE1);
    TCCR1B = (uint8_t)((1U << ICES1) | (1U << WGM13) | (1U << WGM12) | (1U << CS10));
}
#endif

int main(void)
{
    RESULT[0] = 0;
    start();
    sei();
    for (;;) {
    }
}
