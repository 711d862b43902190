// SPDX-License-Identifier: MIT
//
// Model of UART 0 in the place of simavr's: frames with their exact cycles from UBRR0, U2X0 and the
// frame format; a double-buffered transmitter; a receiver with two buffered characters and one in
// the shift register, which the start bit of the next character overwrites. A bit is decided after
// the last of its three samples; a character is received when its stop bit is decided. The
// interrupts of RXC0 and UDRE0 are levels, as on the part: they come again until their cause is
// gone. A reset cuts the frame on its way out.
//
// Refused: synchronous modes, multi-processor mode and 9 data bits. Not modelled: the part's
// transmitter waits up to one bit time for its free-running bit clock (here a frame starts at
// once); its receiver sees a start bit up to one sample late, and rejects some start bits. A frame
// is received whole even if the receiver is enabled in its middle.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <avr_uart.h>
#include <sim_avr.h>

#include "bus.h"
#include "bus_frame.h"
#include "own_time.h"
#include "peripheral.h"

// Frames already on the bus that end in the future; a power of two.
#define UART_INCOMING 1024
// Two buffered characters and the shift register.
#define UART_FIFO 3

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
    avr_uart_t *part; // register addresses and vectors, from simavr's description
    const struct uart_hooks *hooks;
    struct bus *bus;
    int index; // of this board on the bus
    const struct own_time *time;

    bool shifting; // a frame is on its way out
    bool waiting;  // one more character waits in UDR0
    uint8_t waiting_data;
    uint64_t shift_end;         // cycle at which the frame on its way out ends
    struct bus_frame *outgoing; // the frame on its way, NULL if it never reached the bus

    struct uart_char fifo[UART_FIFO]; // received, the oldest first
    int fifo_count;
    bool overrun;    // DOR0
    uint8_t rx_last; // what UDR0 reads while the fifo is empty

    // Frames on the bus, a ring: from `first` on not received yet, from `begun` on not begun.
    struct bus_frame *incoming[UART_INCOMING];
    unsigned incoming_first, incoming_last;
    unsigned incoming_begun; // start bits seen
};

// The cycles of one bit, by the registers.
uint32_t uart_bit_cycles(const struct uart *uart);

// The bits of one frame by the registers: start, data, parity and stop.
uint32_t uart_frame_bits(const struct uart *uart);

// The bits of one frame before its stop bits, by the registers.
uint32_t uart_bits_before_stop(const struct uart *uart);

// The transmitter is enabled.
bool uart_can_send(const struct uart *uart);

// Puts the model in place of simavr's. Call once, between the part's init and its first reset.
// `index`: the board's number on the bus, whose frames are in the bench's time.
void uart_attach(struct uart *uart,
                 avr_t *avr,
                 struct bus *bus,
                 int index,
                 const struct own_time *time,
                 const struct uart_hooks *hooks);

// The part was reset: a frame on its way out is cut.
void uart_reset(struct uart *uart);

// A frame of another sender has started on the bus; it ends at a later cycle than this board has
// reached. The bus calls it with the UART as `uart`.
void uart_receive(void *uart, struct bus_frame *frame);

// Raises the interrupts whose levels are up and withdraws the others. Call after every service of
// an interrupt.
void uart_follow_levels(struct uart *uart);

// The bus driver was switched off at this cycle: a frame on its way out is cut.
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
