// SPDX-License-Identifier: MIT

#include "uart.h"

#include <sim_regbit.h>

#include "bus.h"
#include "uart_bits.h"

// A receiver that samples in the middle of bits loses step beyond about 4.5 % over 11 bits.
#define SPEED_TOLERANCE_PER_MILLE 45

uint32_t uart_bit_cycles(const struct uart *u)
{
    const uint8_t *data = u->avr->data;
    uint32_t divisor =
        data[u->part->ubrrl.reg] | ((data[u->part->ubrrh.reg] & 0xFU) << 8);

    return (divisor + 1) * ((data[u->part->r_ucsra] & U2X) != 0 ? 8 : 16);
}

uint32_t uart_bits_before_stop(const struct uart *u)
{
    uint32_t data_bits = 5 + ((uart_ucsrc(u) >> 1) & 3U);
    uint32_t parity_bits = (uart_ucsrc(u) & UPM) != 0 ? 1 : 0;

    return 1 + data_bits + parity_bits;
}

uint32_t uart_frame_bits(const struct uart *u)
{
    return uart_bits_before_stop(u) + ((uart_ucsrc(u) & USBS) != 0 ? 2 : 1);
}

bool uart_can_send(const struct uart *u)
{
    return (uart_ucsrb(u) & TXEN) != 0;
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

void uart_start_frame(struct uart *u, uint8_t data, uint64_t cycle)
{
    uint32_t bit = uart_bit_cycles(u);
    struct bus_frame frame = {
        .start = cycle,
        .end = cycle + (uint64_t)bit * uart_frame_bits(u),
        .bit_cycles_x1000 = bit * 1000,
        .sender = u->index,
        .data = data,
        .format = uart_ucsrc(u) & FORMAT,
    };

    u->shifting = true;
    u->shift_end = frame.end;
    u->hooks->byte(u->hooks->board, true, data, cycle);
    u->outgoing =
        u->hooks->may_send(u->hooks->board) ? bus_start(u->bus, &frame) : NULL;
}

// The frame on its way has ended: the waiting one follows at once, or transmission is complete.
static void happen_sent(struct uart *u)
{
    uint64_t end = u->shift_end;

    u->shifting = false;
    u->outgoing = NULL;
    if (u->waiting) {
        u->waiting = false;
        uart_start_frame(u, u->waiting_data, end);
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

// From the beginning of a bit until the receiver has decided it: by the majority of samples 8, 9
// and 10 of 16, or 4, 5 and 6 of 8.
static uint32_t decided_cycles(const struct uart *u)
{
    bool double_speed = (u->avr->data[u->part->r_ucsra] & U2X) != 0;

    return double_speed ? uart_bit_cycles(u) / 8 * 6 : uart_bit_cycles(u) / 16 * 10;
}

static uint64_t frame_begun_at(const struct uart *u, const struct bus_frame *frame)
{
    return frame->start + decided_cycles(u);
}

static uint64_t frame_heard_at(const struct uart *u, const struct bus_frame *frame)
{
    return frame->start + uart_bits_before_stop(u) * (uint64_t)uart_bit_cycles(u) +
           decided_cycles(u);
}

static bool speed_fits(const struct uart *u, const struct bus_frame *frame)
{
    uint32_t mine = uart_bit_cycles(u) * 1000;
    uint32_t theirs = frame->bit_cycles_x1000;
    uint32_t off = (mine > theirs) ? mine - theirs : theirs - mine;

    return off <= theirs / 1000 * SPEED_TOLERANCE_PER_MILLE;
}

// A new start bit: the character that waits in the shift register is run over.
static void run_over(struct uart *u)
{
    if (u->fifo_count == UART_FIFO) {
        u->overrun = true;
        u->fifo_count--;
    }
}

static void receive(struct uart *u, const struct bus_frame *frame, uint64_t cycle)
{
    struct uart_char heard = {.data = frame->data, .errors = 0};
    unsigned other = frame->format ^ (uart_ucsrc(u) & FORMAT);

    if ((uart_ucsrb(u) & RXEN) == 0) {
        return;
    }
    if (frame->corrupted || !speed_fits(u, frame) || (other & UCSZ) != 0) {
        heard.data = (uint8_t)~frame->data;
        heard.errors = FE;
    } else if (other != 0) {
        heard.errors = UPE;
    }
    run_over(u); // by a start bit that fell into another frame
    u->fifo[u->fifo_count++] = heard;
    u->hooks->byte(u->hooks->board, false, heard.data, cycle);
}

static void happen_begun(struct uart *u)
{
    u->incoming_begun++;
    if ((uart_ucsrb(u) & RXEN) != 0) {
        run_over(u);
    }
}

static void happen_heard(struct uart *u, uint64_t cycle)
{
    const struct bus_frame *frame = u->incoming[u->incoming_first++ % UART_INCOMING];

    receive(u, frame, cycle);
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

static uint64_t begun_due(const struct uart *u)
{
    return (u->incoming_begun == u->incoming_last)
               ? UINT64_MAX
               : frame_begun_at(u, u->incoming[u->incoming_begun % UART_INCOMING]);
}

static uint64_t earlier(uint64_t a, uint64_t b)
{
    return (a < b) ? a : b;
}

static uint64_t next_due(const struct uart *u)
{
    return earlier(sent_due(u), earlier(begun_due(u), heard_due(u)));
}

void uart_sync(struct uart *u, uint64_t cycle)
{
    for (uint64_t due = next_due(u); due <= cycle; due = next_due(u)) {
        if (due == sent_due(u)) {
            happen_sent(u);
        } else if (due == begun_due(u)) {
            happen_begun(u);
        } else {
            happen_heard(u, due);
        }
    }
}

// A start bit wakes nobody: what it does waits for the next look.
static uint64_t next_wake(const struct uart *u)
{
    return earlier(sent_due(u), heard_due(u));
}

static avr_cycle_count_t on_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct uart *u = param;
    uint64_t due;

    (void)when;
    uart_sync(u, avr->cycle);
    due = next_wake(u);
    return (due == UINT64_MAX) ? 0 : due;
}

void uart_schedule(struct uart *u)
{
    uint64_t due = next_wake(u);

    if (due == UINT64_MAX) {
        avr_cycle_timer_cancel(u->avr, on_due, u);
    } else {
        avr_cycle_timer_register(
            u->avr, (due > u->avr->cycle) ? due - u->avr->cycle : 0, on_due, u);
    }
}

void uart_hear(struct uart *u, struct bus_frame *frame)
{
    if (u->incoming_last - u->incoming_first < UART_INCOMING) {
        u->incoming[u->incoming_last++ % UART_INCOMING] = frame;
        uart_schedule(u);
    }
}
