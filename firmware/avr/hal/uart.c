// SPDX-License-Identifier: MIT
// The bus is on USART 0; timer 2 measures silences. An interrupt handler only moves one byte.
// Receiving pauses during sending, because the bus is half duplex: only one of the three handlers
// is active at a time.
//
// Every received byte sets timer 2 back to 0. The timer's compare flag, for which no interrupt is
// enabled, stands for a silence: the next byte's handler and the main loop find the flag set,
// however late they look.
#include "hal/uart.h"

#include <avr/interrupt.h>
#include <avr/io.h>

#include "avr/hal/pins.h"       // pins_write_rs485
#include "avr/hal/uart_place.h" // uart_place

// A count of timer 2 is 256 cycles, or 1024 where eight bits of shorter counts are not enough.
#define COUNT_256  ((uint8_t)(_BV(CS22) | _BV(CS21)))
#define COUNT_1024 ((uint8_t)(_BV(CS22) | _BV(CS21) | _BV(CS20)))

// Where a divisor has eight bits, the upper four bits of UBRR0 stay 0.
#if UART_DIVISOR_BITS == 8
#define RATE_REGISTER UBRR0L
#else
#define RATE_REGISTER UBRR0
#endif

#define FORMAT_NONE ((uint8_t)(_BV(USBS0) | _BV(UCSZ01) | _BV(UCSZ00)))
#define FORMAT_ODD  ((uint8_t)(_BV(UPM01) | _BV(UPM00) | _BV(UCSZ01) | _BV(UCSZ00)))

#if defined(USART_RX_vect)
#define RECEIVE_VECTOR  USART_RX_vect
#define EMPTY_VECTOR    USART_UDRE_vect
#define COMPLETE_VECTOR USART_TX_vect
#else
#define RECEIVE_VECTOR  USART0_RX_vect
#define EMPTY_VECTOR    USART0_UDRE_vect
#define COMPLETE_VECTOR USART0_TX_vect
#endif

// Values of UCSR0B. The receiver is off from the moment when a reply is made until it has left:
// bytes that come meanwhile belong to no request.
#define ENABLE_NONE     ((uint8_t)(_BV(RXEN0) | _BV(TXEN0)))
#define ENABLE_RECEIVE  ((uint8_t)(_BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0)))
#define ENABLE_MUTE     ((uint8_t)(_BV(TXEN0)))
#define ENABLE_SEND     ((uint8_t)(_BV(UDRIE0) | _BV(TXEN0)))
#define ENABLE_COMPLETE ((uint8_t)(_BV(TXCIE0) | _BV(TXEN0)))

// A handler first masks its own source and then lets the step interrupts in, before it saves
// anything else. The step interrupts therefore wait for 13 cycles at most (15 on the Mega). Then it
// jumps to its body, which ends by a jump to serial_over (uart_receive.S). The source is enabled
// again with interrupts off, when the body has left the stack: otherwise each handler would nest in
// the one before, where handlers are slower than the bus. The linker makes RCALL and RJMP of CALL
// and JMP where the body is near, as it is here.
#define SERIAL_VECTOR(vector, masked, body)                                              \
    ISR(vector, ISR_NAKED)                                                               \
    {                                                                                    \
        __asm__ volatile("push r24\n\t"                                                  \
                         "ldi r24, %[mask]\n\t"                                          \
                         "sts %[control], r24\n\t"                                       \
                         "sei\n\t"                                                       \
                         "nop\n\t" /* what SEI lets run first: shorter than JMP */       \
                         body                                                            \
                         :                                                               \
                         : [mask] "M"(masked), [control] "n"(_SFR_MEM_ADDR(UCSR0B)));    \
    }
#define SERIAL_BODY(body, ...)                                                           \
    static void serial_##body(void) __asm__("__vector_" #body)                           \
        __attribute__((__VA_ARGS__, used));                                              \
    static void serial_##body(void)

// Keep Z and the status register on the stack.
#define SAVE_Z    "push r30\n\tin r30, __SREG__\n\tpush r30\n\tpush r31\n\t"
#define RESTORE_Z "pop r31\n\tpop r30\n\tout __SREG__, r30\n\tpop r30\n\t"

// Budget: 105 cycles for the first character behind a silence, 80 for any other; a character takes
// 176 cycles at 1,000,000 baud. Its body is uart_receive.S.
SERIAL_VECTOR(RECEIVE_VECTOR, ENABLE_NONE, "jmp __vector_receive")

// Budget: 90 cycles, once a character. By hand, because the compiler takes 25 cycles more, and a
// reply has up to 255 characters; r24 is saved already.
//
// When step interrupts have delayed this handler, the transmitter has run empty and set TXC0,
// although the reply is not at its end. Clear that flag together with the store of the byte, before
// the byte can have left.
SERIAL_VECTOR(EMPTY_VECTOR, ENABLE_MUTE, "jmp __vector_send")
SERIAL_BODY(send, naked)
{
    __asm__ volatile(SAVE_Z "lds r30, %[next]\n\t"
                            "lds r31, %[next] + 1\n\t"
                            "ld r24, Z+\n\t"
                            "cli\n\t"
                            "sts %[data], r24\n\t"
                            "ldi r24, %[flags]\n\t"
                            "sts %[status], r24\n\t"
                            "sei\n\t"
                            "sts %[next] + 1, r31\n\t"
                            "sts %[next], r30\n\t"
                            "lds r24, %[end]\n\t"
                            "cp r30, r24\n\t"
                            "lds r24, %[end] + 1\n\t"
                            "cpc r31, r24\n\t"
                            "ldi r24, %[more]\n\t"
                            "brne 1f\n\t"
                            "ldi r24, %[last]\n"
                            "1: sts %[control], r24\n\t" RESTORE_Z "jmp serial_over"
                     :
                     : [next] "i"(&uart_place.next_byte),
                       [end] "i"(&uart_place.end_byte),
                       [data] "n"(_SFR_MEM_ADDR(UDR0)),
                       [status] "n"(_SFR_MEM_ADDR(UCSR0A)),
                       [flags] "M"(_BV(TXC0) | _BV(U2X0)),
                       [control] "i"(&uart_place.control_after),
                       [more] "M"(ENABLE_SEND),
                       [last] "M"(ENABLE_COMPLETE));
}

// Inline: a handler that calls a function saves twice as many registers.
static inline __attribute__((always_inline)) void begin_reception(void)
{
    uart_place.next_byte = uart_place.first_byte;
    uart_place.end_byte = uart_place.first_byte + UART_BUFFER_BYTES;
    uart_place.first_silence = uart_place.first_byte;
    uart_place.control_after = ENABLE_RECEIVE;
}

// Budget: 145 cycles, once a reply.
SERIAL_VECTOR(COMPLETE_VECTOR, ENABLE_MUTE, "call __vector_sent\n\tjmp serial_sent_over")
SERIAL_BODY(sent, signal)
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
    uart_place.first_byte = bytes;
    UCSR0A = (uint8_t)_BV(U2X0);
    uart_enable_reception();
}

void uart_set(uart_divisor divisor, enum uart_parity parity, uint16_t silence_counts)
{
    // The parity field of UCSR0C is 3 for odd and 2 for even, where `parity` is 1 and 2.
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

uint16_t uart_age_units(void)
{
    uint8_t count = 0;
    bool overflowed = false;

    // The overflow may come between the two reads.
    do {
        count = TCNT2;
        overflowed = (TIFR2 & _BV(TOV2)) != 0;
    } while (TCNT2 < count);
    uint16_t counts = overflowed ? (uint16_t)(count + 256u) : count;

    // A unit is 64 cycles. At 16 MHz a count of 256 is short enough for every rate.
    return (
        uint16_t)(counts << (UART_DIVISOR_BITS > 8 && TCCR2B == COUNT_1024 ? 4u : 2u));
}

bool uart_holds(void)
{
    return uart_place.next_byte != uart_place.first_byte;
}

bool uart_received(uint16_t *count)
{
    // The order of the three reads matters: a byte that comes meanwhile either ends the silence, or
    // it comes after the silence and is not counted here. A silence ahead of the first byte in the
    // buffer is not a silence behind any byte.
    cli();
    const uint8_t *to = uart_place.next_byte;
    sei();
    bool ended = uart_silent();
    cli();
    const uint8_t *silence = uart_place.first_silence;
    sei();

    if (silence != uart_place.first_byte) {
        to = silence;
        ended = true;
    }
    *count = (uint16_t)(to - uart_place.first_byte);
    return ended;
}

void uart_drop(uint16_t count)
{
    uint8_t *to = uart_place.first_byte;
    const uint8_t *from = uart_place.first_byte + count;

    // The receive interrupt waits only while one byte is moved. When no byte is left to move, it
    // stays masked until next_byte is right.
    for (;;) {
        UCSR0B = ENABLE_NONE;
        if (from == uart_place.next_byte) {
            break;
        }
        UCSR0B = ENABLE_RECEIVE;
        *to = *from;
        to++;
        from++;
    }
    uart_place.next_byte = to;
    if (uart_place.first_silence != uart_place.first_byte) {
        // The buffer's front if it was right behind these.
        uart_place.first_silence -= count;
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
    count = uart_place.overruns;
    uart_place.overruns = 0;
    sei();
    return count;
}

void uart_send(uint16_t length)
{
    uart_place.next_byte = uart_place.first_byte;
    uart_place.end_byte = uart_place.first_byte + length;
    pins_write_rs485(true);
    UCSR0B = ENABLE_SEND;
}

bool uart_sending(void)
{
    return (UCSR0B & (_BV(UDRIE0) | _BV(TXCIE0))) != 0;
}
