// SPDX-License-Identifier: MIT
// Flags that are set long before their interrupts are enabled, with I set: each is served when the
// instruction that enables it has ended (test_statistics.py).

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

ISR(BADISR_vect, ISR_NAKED)
{
    __asm__ volatile("reti\n\t");
}

#define PAUSE() __asm__ volatile(".rept 8\n\tnop\n\t.endr\n\t" ::)
#define LET_IN(mask, bits)                                                               \
    do {                                                                                 \
        (mask) = (bits);                                                                 \
        PAUSE();                                                                         \
    } while (0)
#define PASS_ALL(n)                                                                      \
    do {                                                                                 \
        OCR##n##A = 50;                                                                  \
        OCR##n##B = 60;                                                                  \
        TCCR##n##B = 1;                                                                  \
        __builtin_avr_delay_cycles(600);                                                 \
        TCCR##n##B = 0;                                                                  \
    } while (0)
#define LET_ALL_IN(n)                                                                    \
    do {                                                                                 \
        LET_IN(TIMSK##n, 1U << OCIE1A);                                                  \
        LET_IN(TIMSK##n, 1U << OCIE1B);                                                  \
        LET_IN(TIMSK##n, 1U << TOIE1);                                                   \
        TIMSK##n = 0;                                                                    \
    } while (0)

int main(void)
{
    PASS_ALL(0);
    PASS_ALL(2);
    TCNT1 = 0xFF80;
    PASS_ALL(1);
    EICRA = 0x05; // any edge
#if defined(__AVR_ATmega2560__)
    DDRD = PORTD = 0x03;
#else
    DDRD = PORTD = 0x0C;
#endif
    UCSR0B = (uint8_t)(1U << TXEN0);
    UDR0 = 0x55;
    WDTCSR = (uint8_t)((1U << WDCE) | (1U << WDE));
    WDTCSR = (uint8_t)(1U << WDIE);
    __builtin_avr_delay_cycles(300000);
    WDTCSR = 0;
    sei();
    PAUSE();
    LET_ALL_IN(0);
    LET_ALL_IN(1);
    LET_ALL_IN(2);
    LET_IN(EIMSK, 0x01);
    LET_IN(EIMSK, 0x03);
    LET_IN(UCSR0B, (uint8_t)((1U << TXEN0) | (1U << TXCIE0)));
    LET_IN(WDTCSR, (uint8_t)(1U << WDIE));
    cli();
    RESULT[0] = 0x600D;
    for (;;) {
    }
}
