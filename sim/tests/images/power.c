// SPDX-License-Identifier: MIT
// For resets and power cuts: drives what a board drives, steps, and writes one byte of EEPROM after
// the other, each start's number in turn. cause = MCUSR at the start; starts counts in RAM that no
// start-up code clears, from what is there.

#include <avr/interrupt.h>
#include <avr/io.h>

#if defined(__AVR_ATmega2560__)
#define SET_OUTPUTS                                                                      \
    do {                                                                                 \
        DDRA = PORTA = 0x02;        /* ENABLE */                                         \
        DDRE = PORTE = 0x08 | 0x20; /* PERMIT, RS485_DE */                               \
        DDRB = 0x40;                /* STEP */                                           \
    } while (0)
#else
#define SET_OUTPUTS                                                                      \
    do {                                                                                 \
        DDRD = PORTD = 0x20 | 0x40 | 0x08;                                               \
        DDRB = 0x04;                                                                     \
    } while (0)
#endif

#define BYTES 64

uint8_t cause;
volatile uint8_t known = 1; // .data: the start-up code's
volatile uint8_t starts __attribute__((section(".noinit")));
volatile uint16_t overflows;
volatile uint16_t rounds;

ISR(TIMER1_OVF_vect)
{
    overflows++;
}

static void write(uint16_t address, uint8_t value)
{
    while ((EECR & (1U << EEPE)) != 0) {
        rounds++;
    }
    EEAR = address;
    EEDR = value;
    cli();
    EECR = (uint8_t)(1U << EEMPE);
    EECR |= (uint8_t)(1U << EEPE);
    sei();
}

__attribute__((noinline)) static void one_round(uint8_t number)
{
    for (uint16_t i = 0; i < BYTES; i++) {
        write(i, number);
        UDR0 = number;
    }
}

int main(void)
{
    cause = MCUSR;
    MCUSR = 0;
    starts = (uint8_t)(starts + known);
    SET_OUTPUTS;
    UBRR0 = 16;
    UCSR0A = (uint8_t)(1U << U2X0);
    UCSR0B = (uint8_t)(1U << TXEN0);
    OCR1A = 999;
    OCR1B = 31;
    TCCR1A = (uint8_t)((1U << COM1B1) | (1U << COM1B0) | (1U << WGM11) | (1U << WGM10));
    TIMSK1 = (uint8_t)(1U << TOIE1);
    TCCR1B = (uint8_t)((1U << WGM13) | (1U << WGM12) | (1U << CS10));
    sei();
    for (;;) {
        one_round(starts);
    }
}
