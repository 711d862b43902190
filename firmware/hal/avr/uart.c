// SPDX-License-Identifier: MIT
// USART 0: 8E1. Interrupt handlers only move one byte. Receiving pauses while sending: the line is
// half duplex, so only one of the three handlers is active at a time.
#include "hal/uart.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "config.h"       // CONFIG_BAUD
#include "hal/avr/pins.h" // pins_write_rs485

// The main loop may be away for so many characters: 3 ms at 115200 baud 8E1, or 12 ms.
#if defined(CONFIG_BOARD_UNO)
#define RECEIVE_SLOTS 32u
#else
#define RECEIVE_SLOTS 128u
#endif
#define UBRR_VALUE ((CONFIG_TIMER_HZ + 4uL * CONFIG_BAUD) / (8uL * CONFIG_BAUD) - 1uL)

static volatile uint8_t received[RECEIVE_SLOTS];
static volatile uint8_t receive_head; // written by the interrupt (free running)
static volatile uint8_t receive_tail; // written by the main loop
static volatile uint8_t overruns;

static const uint8_t *volatile send_next;
static volatile uint16_t send_left;
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

void uart_start(void)
{
    UBRR0 = (uint16_t)UBRR_VALUE;
    UCSR0A = (uint8_t)_BV(U2X0);
    UCSR0C = (uint8_t)(_BV(UPM01) | _BV(UCSZ01) | _BV(UCSZ00));
    UCSR0B = (uint8_t)(_BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0));
}

#define ENABLE_RECEIVE  ((uint8_t)(_BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0)))
#define ENABLE_SEND     ((uint8_t)(_BV(UDRIE0) | _BV(RXEN0) | _BV(TXEN0)))
#define ENABLE_COMPLETE ((uint8_t)(_BV(TXCIE0) | _BV(RXEN0) | _BV(TXEN0)))
#define ENABLE_NONE     ((uint8_t)(_BV(RXEN0) | _BV(TXEN0)))

// A handler first masks its own source and then lets the step interrupts in, before it saves
// anything else: it keeps them waiting for 14 cycles. Its body is another function, an interrupt
// handler to the compiler; it ends by taking its source in again.
#define SERIAL_HANDLER(vector, body)                                                     \
    void serial_##body(void) __asm__("__vector_" #body) __attribute__((signal, used));   \
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
    void serial_##body(void)

static inline void store(uint8_t status, uint8_t byte)
{
    uint8_t head = receive_head;

    // A byte with a wrong parity or stop bit is left out: the frame's checksum then fails.
    if ((status & (_BV(FE0) | _BV(UPE0))) != 0) {
        return;
    }
    if ((status & _BV(DOR0)) != 0 || (uint8_t)(head - receive_tail) == RECEIVE_SLOTS) {
        overruns++;
        return;
    }
    received[head & (RECEIVE_SLOTS - 1u)] = byte;
    receive_head = (uint8_t)(head + 1u);
}

// Budget: 110 cycles, once a character (1528 cycles at 115200 baud).
SERIAL_HANDLER(RECEIVE_VECTOR, receive)
{
    uint8_t status = UCSR0A;

    store(status, UDR0);
    UCSR0B = ENABLE_RECEIVE;
}

// Budget: 110 cycles, once a character.
SERIAL_HANDLER(EMPTY_VECTOR, send)
{
    const uint8_t *next = send_next;
    uint16_t left = (uint16_t)(send_left - 1u);

    UDR0 = *next;
    send_next = next + 1;
    send_left = left;
    UCSR0B = left == 0 ? ENABLE_COMPLETE : ENABLE_SEND;
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
    UCSR0B = ENABLE_RECEIVE;
}

bool uart_take(uint8_t *byte)
{
    uint8_t tail = receive_tail;

    if (tail == receive_head) {
        return false;
    }
    *byte = received[tail & (RECEIVE_SLOTS - 1u)];
    receive_tail = (uint8_t)(tail + 1u);
    return true;
}

uint8_t uart_take_overruns(void)
{
    uint8_t count = 0;

    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        count = overruns;
        overruns = 0;
    }
    return count;
}

void uart_send(const uint8_t *bytes, uint16_t length)
{
    pins_write_rs485(true);
    send_next = bytes;
    send_left = length;
    sending = true;
    // Clear a stale transmit-complete flag (write one), then let the handler send.
    UCSR0A = (uint8_t)(_BV(TXC0) | _BV(U2X0));
    UCSR0B = ENABLE_SEND;
}

bool uart_sending(void)
{
    return sending;
}
