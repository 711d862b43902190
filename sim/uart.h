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

#include "bus.h"
#include "bus_frame.h"
#include "peripheral.h"

#define UART_INCOMING                                                                    \
    1024            // frames already on the bus that end in the future; a power of two
#define UART_FIFO 3 // two buffered characters and the shift register

struct uart_char {
    uint8_t data;
    uint8_t errors; // FE0 and UPE0 as in UCSR0A
};

struct uart_hooks {
    struct peripheral_host host;
    // True while the board's driver puts its frames on the bus (RS-485 driver enable).
    bool (*may_send)(void *board);
    // A byte's start bit begins (sent), or the receiver has a byte, at this cycle.
    void (*byte)(void *board, bool sent, uint8_t byte, uint64_t cycle);
};

struct uart {
    avr_t *avr;
    avr_uart_t *part;
    const struct uart_hooks *hooks;
    struct bus *bus;
    int index; // of this board on the bus

    bool shifting, waiting; // a frame is on its way out; one more waits in UDR0
    uint8_t waiting_data;
    uint64_t shift_end;
    struct bus_frame *outgoing; // the frame on its way, NULL if it never reached the bus

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

// Puts the model in place of simavr's. Call once, between the part's init and its first reset.
// `index`: the board's number on the bus.
void uart_attach(struct uart *uart,
                 avr_t *avr,
                 struct bus *bus,
                 int index,
                 const struct uart_hooks *hooks);

// The part was reset: a frame on its way out is cut.
void uart_reset(struct uart *uart);

// A frame of another sender has started on the bus; it ends at a later cycle than this board has
// reached. The bus calls it with the UART as `uart`.
void uart_hear(void *uart, struct bus_frame *frame);

// Raises the interrupts of the levels that are up, takes back the others. Call after every service
// of an interrupt.
void uart_follow_levels(struct uart *uart);

// The driver was switched off at this cycle: a frame on its way is cut.
void uart_driver_off(struct uart *uart, uint64_t cycle);

// ---- between uart.c (frames in time) and uart_registers.c (the program's view) ----

// The registers UCSR0B and UCSR0C.
static inline uint8_t uart_ucsrb(const struct uart *uart)
{
    return uart->avr->data[uart->part->r_ucsrb];
}

static inline uint8_t uart_ucsrc(const struct uart *uart)
{
    return uart->avr->data[uart->part->r_ucsrc];
}

// Everything that takes effect up to and including this cycle happens now, in order.
void uart_sync(struct uart *uart, uint64_t cycle);

// Schedules the next effect with simavr. Call after anything that may make an effect come sooner.
void uart_schedule(struct uart *uart);

// Starts a frame at this cycle; the transmitter must be idle.
void uart_start_frame(struct uart *uart, uint8_t data, uint64_t cycle);
