// SPDX-License-Identifier: MIT
//
// Model of UART 0 in the place of simavr's: frames with their exact cycles from UBRR0, U2X0 and
// the frame format; double-buffered transmitter; receiver with two buffered characters and one
// waiting in the shift register, which the start bit of the next one runs over. A bit is decided
// behind the last of its three samples, a character is there when its stop bit is. Interrupts on
// RXC0 and UDRE0 are levels, as on the part: they come again until their cause is gone. A reset
// cuts the frame on its way out.
//
// Not modelled: synchronous modes and multi-processor mode (refused), and the up to one bit time by
// which the part's transmitter waits for its free-running bit clock (a frame starts at once); up to
// a sample's time by which the receiver sees a start bit late, and start bits that it rejects. A
// frame in whose midst the receiver is switched on is heard whole.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <avr_uart.h>
#include <sim_avr.h>

struct bus;
struct bus_frame;

#define UART_INCOMING                                                                    \
    1024            // frames already on the line that end in the future; a power of two
#define UART_FIFO 3 // two buffered characters and the shift register

struct uart_char {
    uint8_t data;
    uint8_t errors; // FE0 and UPE0 as in UCSR0A
};

struct uart_hooks {
    void *board;
    void (*refuse)(void *board, const char *text);
    // May this board's driver put its frames on the line now (RS-485 driver enable)?
    bool (*may_send)(void *board);
    void (*flag)(void *board, uint8_t vector, uint64_t cycle);
    // A byte starts on its way out, or the receiver has got one.
    void (*byte)(void *board, bool sent, uint8_t byte, uint64_t cycle);
};

struct uart {
    avr_t *avr;
    avr_uart_t *part;
    const struct uart_hooks *hooks;
    struct bus *bus;
    int index; // this board on the line

    bool shifting, waiting; // a frame is on its way out; one more waits in UDR0
    uint8_t waiting_data;
    uint64_t shift_end;
    struct bus_frame
        *outgoing; // the frame on its way, NULL if it never reached the line

    struct uart_char fifo[UART_FIFO];
    int fifo_count;
    bool overrun;
    uint8_t rx_last;

    struct bus_frame *incoming[UART_INCOMING];
    unsigned incoming_first, incoming_last;
    unsigned incoming_begun; // start bits seen
};

// Cycles of one bit, and bits of one frame (start, data, parity, stop), as the registers stand.
uint32_t uart_bit_cycles(const struct uart *uart);
uint32_t uart_frame_bits(const struct uart *uart);

// Bits of a frame that come before its stop bits, as the registers stand.
uint32_t uart_bits_before_stop(const struct uart *uart);

// The transmitter is on.
bool uart_can_send(const struct uart *uart);

void uart_attach(struct uart *uart,
                 avr_t *avr,
                 struct bus *bus,
                 int index,
                 const struct uart_hooks *hooks);
void uart_reset(struct uart *uart);

// A frame has started on the line; it ends at a later cycle than this board has reached.
void uart_hear(struct uart *uart, struct bus_frame *frame);

// The level interrupts: raises what is due. The run loop calls it after every service.
void uart_levels(struct uart *uart);

// The driver was switched off at this cycle: a frame on its way is cut.
void uart_driver_off(struct uart *uart, uint64_t cycle);
