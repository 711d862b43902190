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

// Timer 2 counts 256 cycles, or 1024 where its eight bits would not do.
#define COUNT_256  ((uint8_t)(_BV(CS22) | _BV(CS21)))
#define COUNT_1024 ((uint8_t)(_BV(CS22) | _BV(CS21) | _BV(CS20)))

// The upper four bits of UBRR0 stay 0 where a divisor has eight.
#if UART_DIVISOR_BITS == 8
#define RATE_REGISTER UBRR0L
#else
#define RATE_REGISTER UBRR0
#endif

#define FORMAT_NONE ((uint8_t)(_BV(USBS0) | _BV(UCSZ01) | _BV(UCSZ00)))
#define FORMAT_ODD  ((uint8_t)(_BV(UPM01) | _BV(UPM00) | _BV(UCSZ01) | _BV(UCSZ00)))

static uint8_t *first_byte;

// Where the next byte goes to or comes from, and where that ends.
static uint8_t *volatile next_byte;
static uint8_t *volatile end_byte;

// Where the first silence behind any byte came; the buffer's front: there was none.
static uint8_t *volatile first_silence;
static volatile uint8_t overruns;

static volatile uint8_t control_after; // UCSR0B, once the handler is over

#if defined(USART_RX_vect)
#define RECEIVE_VECTOR  USART_RX_vect
#define EMPTY_VECTOR    USART_UDRE_vect
#define COMPLETE_VECTOR USART_TX_vect
#else
#define RECEIVE_VECTOR  USART0_RX_vect
#define EMPTY_VECTOR    USART0_UDRE_vect
#define COMPLETE_VECTOR USART0_TX_vect
#endif

// The receiver is off from the making of a reply to its end: what comes then belongs to nobody.
#define ENABLE_NONE     ((uint8_t)(_BV(RXEN0) | _BV(TXEN0)))
#define ENABLE_RECEIVE  ((uint8_t)(_BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0)))
#define ENABLE_MUTE     ((uint8_t)(_BV(TXEN0)))
#define ENABLE_SEND     ((uint8_t)(_BV(UDRIE0) | _BV(TXEN0)))
#define ENABLE_COMPLETE ((uint8_t)(_BV(TXCIE0) | _BV(TXEN0)))

// A handler first masks its own source and then lets the step interrupts in, before it saves
// anything else: it keeps them waiting for 15 cycles (17 on the Mega). Its body is another
// function, an interrupt handler to the compiler. Its source is taken in again when the body has
// left the stack, with interrupts off: where handlers are slower than the line, each would nest in
// the one before.
#define SERIAL_HANDLER(vector, body, masked)                                             \
    static void serial_##body(void) __asm__("__vector_" #body)                           \
        __attribute__((signal, used));                                                   \
    ISR(vector, ISR_NAKED)                                                               \
    {                                                                                    \
        __asm__ volatile("push r24\n\t"                                                  \
                         "ldi r24, %[mask]\n\t"                                          \
                         "sts %[control], r24\n\t"                                       \
                         "sei\n\t"                                                       \
                         "rcall __vector_" #body "\n\t"                                  \
                         "rjmp serial_over"                                              \
                         :                                                               \
                         : [mask] "M"(masked), [control] "n"(_SFR_MEM_ADDR(UCSR0B)));    \
    }                                                                                    \
    static void serial_##body(void)

// 14 cycles (15) behind the body. The instruction behind SEI comes before any interrupt.
static void serial_over(void) __asm__("serial_over") __attribute__((naked, used));
static void serial_over(void)
{
    __asm__ volatile("lds r24, %[value]\n\t"
                     "cli\n\t"
                     "sts %[control], r24\n\t"
                     "pop r24\n\t"
                     "sei\n\t"
                     "ret"
                     :
                     : [value] "i"(&control_after), [control] "n"(_SFR_MEM_ADDR(UCSR0B)));
}

// Budget: 125 cycles, once a character (176 cycles at 1,000,000 baud); behind a silence only, else
// 110.
SERIAL_HANDLER(RECEIVE_VECTOR, receive, ENABLE_NONE)
{
    uint8_t status = UCSR0A;
    uint8_t byte = UDR0;
    uint8_t *to = next_byte;

    TCNT2 = 0;
    if ((TIFR2 & _BV(OCF2A)) != 0) {
        TIFR2 = (uint8_t)_BV(OCF2A);
        if (first_silence == first_byte) {
            first_silence = to;
        }
    }
    // A byte with a wrong parity or stop bit is left out: the frame's checksum then fails, as it
    // does after a byte that was lost.
    if ((status & (_BV(DOR0) | _BV(FE0) | _BV(UPE0))) != 0) {
        if ((status & _BV(DOR0)) != 0) {
            overruns++;
        }
    } else if (to != end_byte) {
        *to = byte;
        next_byte = to + 1;
    }
}

// Budget: 115 cycles, once a character.
SERIAL_HANDLER(EMPTY_VECTOR, send, ENABLE_MUTE)
{
    uint8_t *from = next_byte;
    uint8_t byte = *from;

    from++;
    // Where step interrupts kept this one waiting the line has run empty, and said so: that is not
    // the reply's end. At once: with the byte, before it can have left.
    cli();
    UDR0 = byte;
    UCSR0A = (uint8_t)(_BV(TXC0) | _BV(U2X0));
    sei();
    next_byte = from;
    control_after = from == end_byte ? ENABLE_COMPLETE : ENABLE_SEND;
}

static inline void begin_reception(void)
{
    next_byte = first_byte;
    end_byte = first_byte + UART_BUFFER_BYTES;
    first_silence = first_byte;
    control_after = ENABLE_RECEIVE;
}

// Budget: 145 cycles, once a reply.
SERIAL_HANDLER(COMPLETE_VECTOR, sent, ENABLE_MUTE)
{
    pins_write_rs485(false);
    begin_reception();
}

void uart_enable_reception(void)
{
    begin_reception();
    UCSR0B = ENABLE_RECEIVE;
}

void uart_start(uint8_t *bytes)
{
    first_byte = bytes;
    UCSR0A = (uint8_t)_BV(U2X0);
    uart_enable_reception();
}

void uart_set(uart_divisor divisor, enum uart_parity parity, uint16_t silence_counts)
{
    // Odd is 3 and even is 2 in the place where the setting has 1 and 2.
    uint8_t format =
        parity == UART_NONE
            ? FORMAT_NONE
            : (uint8_t)(FORMAT_ODD + _BV(UPM00) - (uint8_t)(parity * _BV(UPM00)));
    uart_divisor rate = (uart_divisor)(divisor - 1u);
    uint8_t count = COUNT_256;

    if (RATE_REGISTER == rate && UCSR0C == format) {
        return;
    }
    RATE_REGISTER = rate;
    UCSR0C = format;
    if (silence_counts >> 8 != 0) {
        silence_counts >>= 2;
        count = COUNT_1024;
    }
    OCR2A = (uint8_t)silence_counts;
    TCCR2B = count;
}

bool uart_silent(void)
{
    return (TIFR2 & _BV(OCF2A)) != 0;
}

bool uart_received(uint16_t *count)
{
    // In this order: a byte that comes meanwhile ends the silence, or is behind it and not one of
    // these. The first byte of all leaves no gap behind it.
    cli();
    const uint8_t *to = next_byte;
    sei();
    bool ended = uart_silent();
    cli();
    const uint8_t *silence = first_silence;
    sei();

    if (silence != first_byte) {
        to = silence;
        ended = true;
    }
    *count = (uint16_t)(to - first_byte);
    return ended;
}

void uart_drop(uint16_t count)
{
    uint8_t *to = first_byte;
    const uint8_t *from = first_byte + count;

    // The receiver is kept waiting for one byte's turn at a time; in the end nothing is left over.
    for (;;) {
        UCSR0B = ENABLE_NONE;
        if (from == next_byte) {
            break;
        }
        UCSR0B = ENABLE_RECEIVE;
        *to = *from;
        to++;
        from++;
    }
    next_byte = to;
    if (first_silence != first_byte) {
        first_silence -= count; // the front when it was at this end
    }
    UCSR0B = ENABLE_RECEIVE;
}

void uart_disable_reception(void)
{
    UCSR0B = ENABLE_MUTE;
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
    next_byte = first_byte;
    end_byte = first_byte + length;
    pins_write_rs485(true);
    UCSR0B = ENABLE_SEND;
}

bool uart_sending(void)
{
    return (UCSR0B & (_BV(UDRIE0) | _BV(TXCIE0))) != 0;
}
