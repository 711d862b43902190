// SPDX-License-Identifier: MIT
// The receiver as the program sees it: 117647 baud, 8E1. The image sleeps, and the handler of each
// character raises PERMIT in its first instruction, until RESULT[0] is not 0 any more. Then it
// takes as many characters as that says at once, status and data in RESULT[1...], and from then on
// when RESULT[0] says so; with 0x100 and more in it it switches the receiver off and on before.
// GPIOR2 (the test pokes it): 0x80 for normal speed, 144 cycles a bit; 0x40 for 7 data bits.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

#if defined(__AVR_ATmega2560__)
#define PERMIT_PORT PORTE
#define PERMIT_DDR  DDRE
#define PERMIT_BIT  3
#elif defined(__AVR_ATmega1284P__)
#define PERMIT_PORT PORTD
#define PERMIT_DDR  DDRD
#define PERMIT_BIT  7
#else
#define PERMIT_PORT PORTD
#define PERMIT_DDR  DDRD
#define PERMIT_BIT  6
#endif

#if defined(USART0_RX_vect)
#define RECEIVED USART0_RX_vect
#else
#define RECEIVED USART_RX_vect
#endif

ISR(RECEIVED, ISR_NAKED)
{
    __asm__ volatile("sbi %[port], %[bit]\n\t"
                     "lds r24, %[udr]\n\t"
                     "cbi %[port], %[bit]\n\t"
                     "reti\n\t"
                     :
                     : [port] "I"(_SFR_IO_ADDR(PERMIT_PORT)),
                       [bit] "I"(PERMIT_BIT),
                       [udr] "n"(_SFR_MEM_ADDR(UDR0)));
}

#define RECEIVING ((uint8_t)(1U << RXEN0))
#define SHOWN     ((uint8_t)((1U << RXC0) | (1U << FE0) | (1U << DOR0) | (1U << UPE0)))

#define OFF_AND_ON   0x100U
#define NORMAL_SPEED 0x80U
#define SEVEN_BITS   0x40U

static void take(uint16_t count)
{
    for (uint16_t i = 0; i < count; i++) {
        RESULT[1U + 2U * i] = UCSR0A & SHOWN;
        RESULT[2U + 2U * i] = UDR0;
    }
}

int main(void)
{
    RESULT[0] = 0;
    PERMIT_DDR = (uint8_t)(1U << PERMIT_BIT);
    UBRR0 = 16;
    UCSR0A = (uint8_t)(1U << U2X0);
    if (GPIOR2 == NORMAL_SPEED) {
        UBRR0 = 8;
        UCSR0A = 0;
    }
    UCSR0C = (uint8_t)((1U << UPM01) | (1U << UCSZ01) | (1U << UCSZ00));
    if (GPIOR2 == SEVEN_BITS) {
        UCSR0C = (uint8_t)((1U << UPM01) | (1U << UCSZ01));
    }
    UCSR0B = (uint8_t)(RECEIVING | (1U << RXCIE0));
    SMCR = (uint8_t)(1U << SE); // idle
    sei();
    while (RESULT[0] == 0) {
        __asm__ volatile("sleep\n\t" ::: "r24", "memory");
    }
    cli();
    for (;;) {
        UCSR0B = RECEIVING;
        while (RESULT[0] == 0) {
        }
        if (RESULT[0] >= OFF_AND_ON) {
            UCSR0B = 0;
            UCSR0B = RECEIVING;
        }
        take(RESULT[0] % OFF_AND_ON);
        RESULT[0] = 0;
    }
}
