// SPDX-License-Identifier: MIT
// What registers hold at a start, in RESULT[0...]; then the image sets each of them.

#include <avr/io.h>

#include "result.h"

int main(void)
{
    RESULT[0] = UCSR0A;
    RESULT[1] = UCSR0B;
    RESULT[2] = UCSR0C;
    RESULT[3] = TCCR1A;
    RESULT[4] = TCCR1B;
    RESULT[5] = TIMSK1;
    RESULT[6] = TIFR1;
    RESULT[7] = TCNT1;
    RESULT[8] = OCR1A;
    RESULT[9] = ACSR & (uint8_t)~(1U << ACO);
    RESULT[10] = PINB;
    UCSR0A = (uint8_t)(1U << U2X0);
    UCSR0B = (uint8_t)((1U << TXEN0) | (1U << RXEN0));
    UCSR0C = (uint8_t)((1U << UPM01) | (1U << UPM00) | (1U << UCSZ01));
    UDR0 = 0x55;
    OCR1A = 999;
    OCR1B = 31;
    TCCR1A = (uint8_t)((1U << COM1B1) | (1U << COM1B0) | (1U << WGM11) | (1U << WGM10));
    TIMSK1 = (uint8_t)(1U << TOIE1);
    TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10));
    ACSR = (uint8_t)((1U << ACBG) | (1U << ACIS1));
    for (;;) {
    }
}
