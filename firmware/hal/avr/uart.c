// SPDX-License-Identifier: MIT
// USART 0, and timer 2 for silences. Interrupt handlers only move one byte. Receiving pauses while
// sending: the line is half duplex, so only one of the three handlers is active at a time.
//
// Every byte sets timer 2 back to 0; its compare flag, for which no interrupt is enabled, is the
// silence: the next byte's handler and the main loop find it there, however late they look.
#include "hal/uart.h"

#include <avr/interrupt.h>
#include <avr/io.h>

#include "hal/avr/pins.h" // pins_write_rs485

// Timer 2 counts 16 us, or 64 us where its eight bits would not do.
#define COUNT_16US ((uint8_t)(_BV(CS22) | _BV(CS21)))
#define COUNT_64US ((uint8_t)(_BV(CS22) | _BV(CS21) | _BV(CS20)))

#define FORMAT_NONE ((uint8_t)(_BV(USBS0) | _BV(UCSZ01) | _BV(UCSZ00)))
#define FORMAT_ODD  ((uint8_t)(_BV(UPM01) | _BV(UPM00) | _BV(UCSZ01) | _BV(UCSZ00)))
#define FORMAT_EVEN ((uint8_t)(_BV(UPM01) | _BV(UCSZ01) | _BV(UCSZ00)))

static uint8_t *buffer;

// Receiving: where the next byte goes and room for how many. Sending: the same of what leaves.
static uint8_t *volatile next;
static volatile uint16_t left;

static volatile uint8_t gap; // `left` at the first silence behind a byte; 0 there was none
static volatile uint8_t overruns;
static volatile bool sending;

#if defined(USART_RX_vect)
#define RECEIVE_VECTOR  USART_RX_vect
#define EMPTY_VECTOR    USART_UDRE_vect
#define COMPLETE_VECTOR USART_TX_vect
#else
#define RECEIVE_VECTOR  USART0_RX_vect
#define EMPTY_VECTOR    USART0_UDRE_vect
#define COMPLETE_VECTOR USART0_TX_vect
#endif

#define ENABLE_RECEIVE  ((uint8_t)(_BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0)))
#define ENABLE_SEND     ((uint8_t)(_BV(UDRIE0) | _BV(RXEN0) | _BV(TXEN0)))
#define ENABLE_COMPLETE ((uint8_t)(_BV(TXCIE0) | _BV(RXEN0) | _BV(TXEN0)))
#define ENABLE_NONE     ((uint8_t)(_BV(RXEN0) | _BV(TXEN0)))

// A handler first masks its own source and then lets the step interrupts in, before it saves
// anything else: it keeps them waiting for 14 cycles. Its body is another function, an interrupt
// handler to the compiler; it ends by taking its source in again.
#define SERIAL_HANDLER(vector, body)                                                     \
    static void serial_##body(void) __asm__("__vector_" #body)                           \
        __attribute__((signal, used));                                                   \
    ISR(vector, ISR_NAKED)                                                               \
    {                                                                                    \
        __asm__ volatile(                                                                \
            "push r24\n\t"                                                               \
            "ldi r24, %[none]\n\t"                                                       \
            "sts %[control], r24\n\t"                                                    \
            "sei\n\t"                                                                    \
            "pop r24\n\t"                                                                \
            "rjmp __vector_" #body                                                       \
            :                                                                            \
            : [none] "M"(ENABLE_NONE), [control] "n"(_SFR_MEM_ADDR(UCSR0B)));            \
    }                                                                                    \
    static void serial_##body(void)

static inline void store(uint8_t status, uint8_t byte)
{
    uint16_t room = left;

    if ((TIFR2 & _BV(OCF2A)) != 0) {
        TIFR2 = (uint8_t)_BV(OCF2A);
        if (gap == 0 && room < UART_BUFFER_BYTES) {
            gap = (uint8_t)room;
        }
    }
    if ((status & _BV(DOR0)) != 0) {
        overruns++;
    }
    // A byte with a wrong parity or stop bit is left out: the frame's checksum then fails.
    if ((status & (_BV(FE0) | _BV(UPE0))) == 0 && room != 0) {
        *next = byte;
        next++;
        left = (uint16_t)(room - 1u);
    }
}

// Budget: 125 cycles, once a character (176 cycles at 1,000,000 baud).
SERIAL_HANDLER(RECEIVE_VECTOR, receive)
{
    uint8_t status = UCSR0A;

    TCNT2 = 0;
    store(status, UDR0);
    UCSR0B = ENABLE_RECEIVE;
}

// Budget: 110 cycles, once a character.
SERIAL_HANDLER(EMPTY_VECTOR, send)
{
    uint8_t *from = next;
    uint16_t after = (uint16_t)(left - 1u);

    UDR0 = *from;
    next = from + 1;
    left = after;
    UCSR0B = after == 0 ? ENABLE_COMPLETE : ENABLE_SEND;
}

static inline void listen(void)
{
    next = buffer;
    left = UART_BUFFER_BYTES;
    gap = 0;
    UCSR0B = ENABLE_RECEIVE;
}

// Budget: 130 cycles, once a reply.
SERIAL_HANDLER(COMPLETE_VECTOR, sent)
{
    pins_write_rs485(false);
    // Whatever was heard while sending belongs to nobody.
    while ((UCSR0A & _BV(RXC0)) != 0) {
        (void)UDR0;
    }
    sending = false;
    listen();
}

void uart_start(uint8_t *into)
{
    buffer = into;
    UCSR0A = (uint8_t)_BV(U2X0);
    listen();
}

void uart_set(uint16_t divisor, enum uart_parity parity, uint16_t silence_16us)
{
    uint16_t rate = (uint16_t)(divisor - 1u);
    uint8_t format = parity == UART_NONE  ? FORMAT_NONE
                     : parity == UART_ODD ? FORMAT_ODD
                                          : FORMAT_EVEN;
    uint8_t count = COUNT_16US;

    if (UBRR0 == rate && UCSR0C == format) {
        return;
    }
    UBRR0 = rate;
    UCSR0C = format;
    if (silence_16us > 255u) {
        silence_16us = silence_16us >> 2;
        count = COUNT_64US;
    }
    OCR2A = (uint8_t)silence_16us;
    TCCR2B = count;
}

uint16_t uart_received(void)
{
    uint16_t room = 0;

    cli();
    room = left;
    sei();
    // In this order: a silence that ends what has just been counted is seen.
    if (gap != 0) {
        room = gap;
    }
    return (uint16_t)(UART_BUFFER_BYTES - room);
}

bool uart_silent(void)
{
    return (TIFR2 & _BV(OCF2A)) != 0;
}

bool uart_ended(void)
{
    return uart_silent() || gap != 0;
}

void uart_drop(uint16_t count)
{
    uint8_t *to = buffer;
    const uint8_t *from = buffer + count;

    // The receiver is kept waiting for one byte's turn at a time; at the end nothing is left behind.
    for (;;) {
        UCSR0B = ENABLE_NONE;
        if (from == next) {
            break;
        }
        UCSR0B = ENABLE_RECEIVE;
        *to = *from;
        to++;
        from++;
    }
    next = to;
    left = (uint16_t)(left + count);
    if (gap != 0) {
        gap = (uint8_t)(gap + count); // 0 when it was at this end
    }
    UCSR0B = ENABLE_RECEIVE;
}

void uart_deafen(void)
{
    cli();
    left = 0;
    sei();
}

void uart_listen(void)
{
    UCSR0B = ENABLE_NONE;
    listen();
}

uint8_t uart_take_overruns(void)
{
    uint8_t count = 0;

    cli();
    count = overruns;
    overruns = 0;
    sei();
    return count;
}

void uart_send(uint16_t length)
{
    // The receiver's handler must not find half of this.
    UCSR0B = ENABLE_NONE;
    pins_write_rs485(true);
    next = buffer;
    left = length;
    sending = true;
    // Clear a stale transmit-complete flag (write one), then let the handler send.
    UCSR0A = (uint8_t)(_BV(TXC0) | _BV(U2X0));
    UCSR0B = ENABLE_SEND;
}

bool uart_sending(void)
{
    return sending;
}
