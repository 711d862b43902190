// SPDX-License-Identifier: MIT
// Interrupts of every kind come: their names are in the simulator's statistics.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

ISR(BADISR_vect, ISR_NAKED)
{
    __asm__ volatile("reti\n\t");
}

#define TIMER_BY(n, mask, clock, cycles)                                                 \
    do {                                                                                 \
        OCR##n##A = 50;                                                                  \
        OCR##n##B = 60;                                                                  \
        TIMSK##n = (mask);                                                               \
        TCCR##n##B = (clock);                                                            \
        __builtin_avr_delay_cycles(cycles);                                              \
        TCCR##n##B = 0;                                                                  \
        TIMSK##n = 0;                                                                    \
    } while (0)
#define TIMER(n, mask) TIMER_BY(n, mask, 1, 600)
#define WIDE_TIMER(n)                                                                    \
    do {                                                                                 \
        TCNT##n = 0xFF80;                                                                \
        TIMER(n, 7);                                                                     \
    } while (0)

static void outside_edges(void)
{
#if defined(__AVR_ATmega2560__)
    EICRA = EICRB = 0x55; // any edge
    EIMSK = 0xFF;
    DDRD = 0x0F;
    DDRE = 0xF0;
    PORTD = 0x0F;
    PORTE = 0xF0;
#else
    EICRA = 0x05;
    EIMSK = 0x03;
    DDRD = 0x0C;
    PORTD = 0x0C;
#endif
    __builtin_avr_delay_cycles(20);
    EIMSK = 0;
}

static void transfer(void)
{
    SPCR = (uint8_t)((1U << SPIE) | (1U << SPE) | (1U << MSTR));
    SPDR = 0x55;
    __builtin_avr_delay_cycles(4000); // libsimavr takes its time: 100 us
    SPCR = 0;
}

int main(void)
{
    sei();
    TIMER_BY(0, 7, 3, 20000); // compare B of timer 0 is modelled at clk/64
    TIMER(2, 7);
    WIDE_TIMER(1);
#if defined(__AVR_ATmega2560__)
    OCR1C = OCR3C = OCR4C = OCR5C = 70;
    TCNT1 = 0xFF80;
    TIMER(1, 0x0F);
    TCNT3 = 0xFF80;
    TIMER(3, 0x0F);
    TCNT4 = 0xFF80;
    TIMER(4, 0x0F);
    TCNT5 = 0xFF80;
    TIMER(5, 0x0F);
#endif
    outside_edges();
    transfer(); // no model of the simulator: it has a number and no name
    UCSR0B = (uint8_t)((1U << TXEN0) | (1U << UDRIE0));
    UCSR0B = (uint8_t)((1U << TXEN0) | (1U << TXCIE0));
    UDR0 = 0x55;
    __builtin_avr_delay_cycles(400);
    UCSR0B = 0;
    EECR = (uint8_t)(1U << EERIE);
    __builtin_avr_delay_cycles(20);
    EECR = 0;
    WDTCSR = (uint8_t)((1U << WDCE) | (1U << WDE));
    WDTCSR = (uint8_t)(1U << WDIE); // 16 ms
    __builtin_avr_delay_cycles(300000);
    cli();
    RESULT[0] = 0x600D;
    for (;;) {
    }
}
