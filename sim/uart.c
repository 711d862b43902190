// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "uart.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <sim_regbit.h>

#include "access.h"
#include "line.h"

// Bits of UCSR0A.
#define RXC  0x80U
#define TXC  0x40U
#define UDRE 0x20U
#define FE   0x10U
#define DOR  0x08U
#define UPE  0x04U
#define U2X  0x02U
#define MPCM 0x01U
// Bits of UCSR0B.
#define RXCIE 0x80U
#define TXCIE 0x40U
#define UDRIE 0x20U
#define RXEN  0x10U
#define TXEN  0x08U
#define UCSZ2 0x04U
// Bits of UCSR0C.
#define UMSEL 0xC0U
#define UPM   0x30U
#define USBS  0x08U

#define FIFO_BUFFERED 2 // the third place is the shift register

// A receiver that samples in the middle of bits loses step beyond about 4.5 % over 11 bits.
#define SPEED_TOLERANCE_PER_MILLE 45

static uint8_t ucsrb(const struct uart *u)
{
    return u->avr->data[u->part->r_ucsrb];
}

static uint8_t ucsrc(const struct uart *u)
{
    return u->avr->data[u->part->r_ucsrc];
}

uint32_t uart_bit_cycles(const struct uart *u)
{
    const uint8_t *data = u->avr->data;
    uint32_t divisor = data[u->part->ubrrl.reg] | ((data[u->part->ubrrh.reg] & 0xFU) << 8);

    return (divisor + 1) * ((data[u->part->r_ucsra] & U2X) != 0 ? 8 : 16);
}

uint32_t uart_bits_before_stop(const struct uart *u)
{
    uint32_t data_bits = 5 + ((ucsrc(u) >> 1) & 3U);
    uint32_t parity_bits = (ucsrc(u) & UPM) != 0 ? 1 : 0;

    return 1 + data_bits + parity_bits;
}

uint32_t uart_frame_bits(const struct uart *u)
{
    return uart_bits_before_stop(u) + ((ucsrc(u) & USBS) != 0 ? 2 : 1);
}

bool uart_can_send(const struct uart *u)
{
    return (ucsrb(u) & TXEN) != 0;
}

// ---- interrupts ----

static void level(struct uart *u, avr_int_vector_t *vector, bool cause, uint64_t cycle)
{
    bool enabled = avr_regbit_get(u->avr, vector->enable) != 0;

    if (!cause || !enabled) {
        vector->pending = 0;
    } else if (!vector->pending) {
        u->hooks->flag(u->hooks->board, vector->vector, cycle);
        (void)avr_raise_interrupt(u->avr, vector);
    }
}

static void levels_at(struct uart *u, uint64_t cycle)
{
    level(u, &u->part->rxc, u->fifo_count > 0, cycle);
    level(u, &u->part->udrc, !u->waiting, cycle);
}

void uart_levels(struct uart *u)
{
    levels_at(u, u->avr->cycle);
}

// ---- transmitter ----

static void start_frame(struct uart *u, uint8_t data, uint64_t cycle)
{
    uint32_t bit = uart_bit_cycles(u);
    struct line_frame frame = {
        .start = cycle,
        .end = cycle + (uint64_t)bit * uart_frame_bits(u),
        .bit_cycles_x1000 = bit * 1000,
        .sender = u->index,
        .data = data,
        .bits = (uint8_t)uart_frame_bits(u),
    };

    u->shifting = true;
    u->shift_end = frame.end;
    u->outgoing = u->hooks->may_send(u->hooks->board) ? line_start(u->line, &frame) : NULL;
}

// The frame on its way has ended: the waiting one follows at once, or transmission is complete.
static void happen_sent(struct uart *u)
{
    uint64_t end = u->shift_end;

    u->shifting = false;
    u->outgoing = NULL;
    if (u->waiting) {
        u->waiting = false;
        start_frame(u, u->waiting_data, end);
        levels_at(u, end);
    } else if ((u->avr->data[u->part->r_ucsra] & TXC) == 0) {
        u->hooks->flag(u->hooks->board, u->part->txc.vector, end);
        (void)avr_raise_interrupt(u->avr, &u->part->txc);
    }
}

void uart_driver_off(struct uart *u, uint64_t cycle)
{
    // The last half of the stop bit carries nothing that a receiver still looks at.
    if (u->outgoing != NULL && cycle + uart_bit_cycles(u) / 2 < u->outgoing->end) {
        u->outgoing->corrupted = true;
    }
}

// ---- receiver ----

static uint64_t frame_heard_at(const struct uart *u, const struct line_frame *frame)
{
    // The stop bit is sampled in its middle.
    return frame->start + uart_bits_before_stop(u) * (uint64_t)uart_bit_cycles(u) +
           uart_bit_cycles(u) / 2;
}

static bool speed_fits(const struct uart *u, const struct line_frame *frame)
{
    uint32_t mine = uart_bit_cycles(u) * 1000;
    uint32_t theirs = frame->bit_cycles_x1000;
    uint32_t off = (mine > theirs) ? mine - theirs : theirs - mine;

    return off <= theirs / 1000 * SPEED_TOLERANCE_PER_MILLE;
}

static void receive(struct uart *u, const struct line_frame *frame)
{
    struct uart_char heard = {.data = frame->data, .errors = 0};
    bool fits = speed_fits(u, frame) && frame->bits == uart_frame_bits(u);

    if ((ucsrb(u) & RXEN) == 0) {
        return;
    }
    if (frame->corrupted || !fits) {
        heard.data = (uint8_t)~frame->data;
        heard.errors = FE;
    }
    if (u->fifo_count == UART_FIFO) { // the character in the shift register is run over
        u->overrun = true;
        u->fifo_count--;
    }
    u->fifo[u->fifo_count++] = heard;
}

static void happen_heard(struct uart *u, uint64_t cycle)
{
    const struct line_frame *frame = u->incoming[u->incoming_first++ % UART_INCOMING];

    receive(u, frame);
    levels_at(u, cycle);
}

// ---- time ----

static uint64_t sent_due(const struct uart *u)
{
    return u->shifting ? u->shift_end : UINT64_MAX;
}

static uint64_t heard_due(const struct uart *u)
{
    return (u->incoming_first == u->incoming_last)
               ? UINT64_MAX
               : frame_heard_at(u, u->incoming[u->incoming_first % UART_INCOMING]);
}

static void sync_to(struct uart *u, uint64_t cycle)
{
    for (;;) {
        uint64_t sent = sent_due(u);
        uint64_t heard = heard_due(u);

        if (sent > cycle && heard > cycle) {
            return;
        }
        if (sent <= heard) {
            happen_sent(u);
        } else {
            happen_heard(u, heard);
        }
    }
}

static uint64_t next_due(const struct uart *u)
{
    uint64_t sent = sent_due(u);
    uint64_t heard = heard_due(u);

    return (sent < heard) ? sent : heard;
}

static avr_cycle_count_t on_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct uart *u = param;
    uint64_t due;

    (void)when;
    sync_to(u, avr->cycle);
    due = next_due(u);
    return (due == UINT64_MAX) ? 0 : due;
}

static void schedule(struct uart *u)
{
    uint64_t due = next_due(u);

    if (due == UINT64_MAX) {
        avr_cycle_timer_cancel(u->avr, on_due, u);
    } else {
        avr_cycle_timer_register(
            u->avr, (due > u->avr->cycle) ? due - u->avr->cycle : 0, on_due, u);
    }
}

void uart_hear(struct uart *u, struct line_frame *frame)
{
    if (u->incoming_last - u->incoming_first < UART_INCOMING) {
        u->incoming[u->incoming_last++ % UART_INCOMING] = frame;
        schedule(u);
    }
}

// ---- the program's view ----

static void write_udr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct uart *u = param;

    (void)address;
    sync_to(u, access_cycle(avr));
    if ((ucsrb(u) & TXEN) == 0 || u->waiting) {
        return; // the part ignores it: transmitter off, or UDRE0 not set
    }
    if (u->shifting) {
        u->waiting = true;
        u->waiting_data = value;
        uart_levels(u);
        return;
    }
    start_frame(u, value, access_cycle(avr) + 1);
    schedule(u);
}

static uint8_t read_udr(avr_t *avr, avr_io_addr_t address, void *param)
{
    struct uart *u = param;

    (void)address;
    sync_to(u, access_cycle(avr));
    if (u->fifo_count > 0) {
        u->rx_last = u->fifo[0].data;
        u->fifo_count--;
        memmove(&u->fifo[0], &u->fifo[1], (size_t)u->fifo_count * sizeof u->fifo[0]);
        u->overrun = false;
        uart_levels(u);
    }
    return u->rx_last;
}

static uint8_t read_ucsra(avr_t *avr, avr_io_addr_t address, void *param)
{
    struct uart *u = param;
    uint8_t kept;

    sync_to(u, access_cycle(avr));
    kept = avr->data[address] & (TXC | U2X | MPCM);
    if (u->fifo_count > 0) {
        kept |= (uint8_t)(RXC | u->fifo[0].errors);
    }
    return (uint8_t)(kept | (u->waiting ? 0U : UDRE) | (u->overrun ? DOR : 0U));
}

static void write_ucsra(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct uart *u = param;

    if ((value & MPCM) != 0) {
        u->hooks->refuse(u->hooks->board, "UART 0: multi-processor mode is not modelled");
    }
    sync_to(u, access_cycle(avr));
    if ((value & TXC) != 0) {
        avr_clear_interrupt(avr, &u->part->txc);
    }
    avr->data[address] = (uint8_t)((avr->data[address] & TXC) | (value & U2X));
    schedule(u); // the speed may have changed
}

static void write_ucsrb(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct uart *u = param;

    avr->data[address] = value;
    if ((value & UCSZ2) != 0) {
        u->hooks->refuse(u->hooks->board, "UART 0: 9 data bits are not modelled");
    }
    if ((value & RXEN) == 0) {
        u->fifo_count = 0; // "disabling the receiver will flush the receive buffer"
        u->overrun = false;
    }
    uart_levels(u);
    if ((value & TXCIE) == 0) {
        u->part->txc.pending = 0;
    } else if ((avr->data[u->part->r_ucsra] & TXC) != 0) {
        (void)avr_raise_interrupt(avr, &u->part->txc);
    }
}

static void write_ucsrc(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct uart *u = param;

    if ((value & UMSEL) != 0) {
        u->hooks->refuse(u->hooks->board, "UART 0: synchronous modes are not modelled");
    }
    avr->data[address] = value;
    schedule(u);
}

static void write_ubrr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    avr->data[address] = value;
    schedule(param);
}

// ---- set-up ----

void uart_reset(struct uart *u)
{
    u->shifting = u->waiting = false;
    u->outgoing = NULL;
    u->fifo_count = 0;
    u->overrun = false;
    u->rx_last = 0;
    u->avr->data[u->part->r_ucsra] = 0;
    u->avr->data[u->part->r_ucsrb] = 0;
    u->avr->data[u->part->r_ucsrc] = 0x06; // the part's initial value: 8 data bits
    schedule(u);
}

static avr_uart_t *find_part(avr_t *avr)
{
    for (avr_io_t *io = avr->io_port; io != NULL; io = io->next) {
        avr_uart_t *part = (avr_uart_t *)(void *)io;

        if (strcmp(io->kind, "uart") == 0 && part->name == '0') {
            return part;
        }
    }
    (void)fputs("pixstep-sim: simavr's part has no UART 0\n", stderr);
    abort();
}

void uart_attach(struct uart *u,
                 avr_t *avr,
                 struct line *line,
                 int index,
                 const struct uart_hooks *hooks)
{
    avr_uart_t *part = find_part(avr);

    u->avr = avr;
    u->part = part;
    u->hooks = hooks;
    u->line = line;
    u->index = index;
    u->incoming_first = u->incoming_last = 0;
    access_take(avr, part->r_udr, read_udr, write_udr, u);
    access_take(avr, part->r_ucsra, read_ucsra, write_ucsra, u);
    access_take(avr, part->r_ucsrb, NULL, write_ucsrb, u);
    access_take(avr, part->r_ucsrc, NULL, write_ucsrc, u);
    access_take(avr, part->ubrrl.reg, NULL, write_ubrr, u);
    access_take(avr, part->ubrrh.reg, NULL, write_ubrr, u);
}
