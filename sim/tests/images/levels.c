// SPDX-License-Identifier: MIT
// Interrupts of the UART that are levels: characters arrive while interrupts are off; when the test
// has written 1 to RESULT[0], they are on for a while. RESULT[1]: how often the receiver's was
// served, RESULT[2], RESULT[3]: the characters, RESULT[4]: how often the transmitter's, RESULT[6]:
// that of a frame that has been sent.

#include <avr/interrupt.h>
#include <avr/io.h>

#include "result.h"

#if defined(USART0_RX_vect)
#define RECEIVED USART0_RX_vect
#define EMPTY    USART0_UDRE_vect
#define SENT     USART0_TX_vect
#else
#define RECEIVED USART_RX_vect
#define EMPTY    USART_UDRE_vect
#define SENT     USART_TX_vect
#endif

#define MOST_EMPTY 5U

ISR(RECEIVED)
{
    uint16_t at = RESULT[1];

    RESULT[2U + at] = UDR0;
    RESULT[1] = at + 1U;
}

ISR(EMPTY)
{
    RESULT[4]++;
    if (RESULT[4] == MOST_EMPTY) {
        UCSR0B = (uint8_t)((1U << RXEN0) | (1U << TXEN0));
    }
}

// Its flag was there before it was enabled.
ISR(SENT)
{
    RESULT[6] = RESULT[6] + 1U;
}

int main(void)
{
    for (uint8_t i = 0; i < 7; i++) {
        RESULT[i] = 0;
    }
    UBRR0 = 16;
    UCSR0A = (uint8_t)(1U << U2X0);
    UCSR0C = (uint8_t)((1U << UPM01) | (1U << UCSZ01) | (1U << UCSZ00));
    UCSR0B = (uint8_t)((1U << RXEN0) | (1U << RXCIE0));
    while (RESULT[0] == 0) {
    }
    sei();
    __builtin_avr_delay_cycles(2000);
    cli();
    UCSR0B = (uint8_t)((1U << RXEN0) | (1U << TXEN0) | (1U << UDRIE0));
    sei();
    __builtin_avr_delay_cycles(2000);
    cli();
    RESULT[5] = 0x600D;
    UCSR0B = (uint8_t)(1U << TXEN0);
    UDR0 = 0x33;
    __builtin_avr_delay_cycles(2000);
    UCSR0B = (uint8_t)((1U << TXEN0) | (1U << TXCIE0));
    sei();
    for (;;) {
    }
}
