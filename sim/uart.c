// SPDX-License-Identifier: MIT

#include "uart.h"

#include <sim_regbit.h>

#include "uart_bits.h"

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

static void follow_level(struct uart *u,
                         avr_int_vector_t *vector,
                         bool cause,
                         uint64_t cycle)
{
    bool enabled = avr_regbit_get(u->avr, vector->enable) != 0;

    if (!cause || !enabled) {
        vector->pending = 0;
    } else if (!vector->pending) {
        peripheral_raise(&u->hooks->host, u->avr, vector, cycle);
    }
}

static void follow_levels_at(struct uart *u, uint64_t cycle)
{
    follow_level(u, &u->part->rxc, u->fifo_count > 0, cycle);
    follow_level(u, &u->part->udrc, !u->waiting, cycle);
}

void uart_follow_levels(struct uart *u)
{
    follow_levels_at(u, u->avr->cycle);
}

// ---- transmitter ----

void uart_start_frame(struct uart *u, uint8_t data, uint64_t cycle)
{
    uint32_t bit = uart_bit_cycles(u);
    uint64_t end = cycle + (uint64_t)bit * uart_frame_bits(u);
    struct bus_frame frame = {
        .start = own_time_to_bench(u->time, cycle),
        .end = own_time_to_bench(u->time, end),
        .bit_cycles_x1000 = (uint32_t)own_time_to_bench(u->time, (uint64_t)bit * 1000),
        .sender = u->index,
        .data = data,
        .format = uart_ucsrc(u) & FORMAT,
    };

    u->shifting = true;
    u->shift_end = end;
    u->hooks->byte(u->hooks->host.board, true, data, cycle);
    u->outgoing =
        u->hooks->may_send(u->hooks->host.board) ? bus_start(u->bus, &frame) : NULL;
}

// The frame on its way out has ended. The waiting one follows at once, or transmission is complete.
static void end_sent_frame(struct uart *u)
{
    uint64_t end = u->shift_end;

    u->shifting = false;
    u->outgoing = NULL;
    if (u->waiting) {
        u->waiting = false;
        uart_start_frame(u, u->waiting_data, end);
        follow_levels_at(u, end);
    } else if ((u->avr->data[u->part->r_ucsra] & TXC) == 0) {
        peripheral_raise(&u->hooks->host, u->avr, &u->part->txc, end);
    }
}

void uart_driver_off(struct uart *u, uint64_t cycle)
{
    // The last half of the stop bit carries nothing that a receiver still looks at.
    if (u->outgoing != NULL && cycle + uart_bit_cycles(u) / 2 < u->shift_end) {
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
    return own_time_from_bench(u->time, frame->start) + decided_cycles(u);
}

static uint64_t frame_received_at(const struct uart *u, const struct bus_frame *frame)
{
    return own_time_from_bench(u->time, frame->start) +
           uart_bits_before_stop(u) * (uint64_t)uart_bit_cycles(u) + decided_cycles(u);
}

static bool speed_fits(const struct uart *u, const struct bus_frame *frame)
{
    uint32_t theirs = (uint32_t)own_time_from_bench(u->time, frame->bit_cycles_x1000);

    return bus_speeds_fit(uart_bit_cycles(u) * 1000, theirs, theirs);
}

// A new start bit overwrites the character that waits in the shift register.
static void overrun_shift_register(struct uart *u)
{
    if (u->fifo_count == UART_FIFO) {
        u->overrun = true;
        u->fifo_count--;
    }
}

static void receive(struct uart *u, const struct bus_frame *frame, uint64_t cycle)
{
    struct uart_char character = {.data = frame->data, .errors = 0};
    unsigned other = frame->format ^ (uart_ucsrc(u) & FORMAT);

    if ((uart_ucsrb(u) & RXEN) == 0) {
        return;
    }
    if (frame->corrupted || !speed_fits(u, frame) || (other & UCSZ) != 0) {
        character.data = (uint8_t)~frame->data;
        character.errors = FE;
    } else if (other != 0) {
        character.errors = UPE;
    }
    overrun_shift_register(u); // by a start bit that fell into another frame
    u->fifo[u->fifo_count++] = character;
    u->hooks->byte(u->hooks->host.board, false, character.data, cycle);
}

static void begin_received_frame(struct uart *u)
{
    u->incoming_begun++;
    if ((uart_ucsrb(u) & RXEN) != 0) {
        overrun_shift_register(u);
    }
}

static void end_received_frame(struct uart *u, uint64_t cycle)
{
    const struct bus_frame *frame = u->incoming[u->incoming_first++ % UART_INCOMING];

    receive(u, frame, cycle);
    follow_levels_at(u, cycle);
}

// ---- time ----

static uint64_t sent_due(const struct uart *u)
{
    return u->shifting ? u->shift_end : UINT64_MAX;
}

static uint64_t received_due(const struct uart *u)
{
    return (u->incoming_first == u->incoming_last)
               ? UINT64_MAX
               : frame_received_at(u, u->incoming[u->incoming_first % UART_INCOMING]);
}

static uint64_t begun_due(const struct uart *u)
{
    return (u->incoming_begun == u->incoming_last)
               ? UINT64_MAX
               : frame_begun_at(u, u->incoming[u->incoming_begun % UART_INCOMING]);
}

static uint64_t next_due(const struct uart *u)
{
    return peripheral_earlier(sent_due(u),
                              peripheral_earlier(begun_due(u), received_due(u)));
}

void uart_sync(struct uart *u, uint64_t cycle)
{
    for (uint64_t due = next_due(u); due <= cycle; due = next_due(u)) {
        if (due == sent_due(u)) {
            end_sent_frame(u);
        } else if (due == begun_due(u)) {
            begin_received_frame(u);
        } else {
            end_received_frame(u, due);
        }
    }
}

// A start bit has no visible effect of its own: the next sync takes it into account.
static uint64_t next_wake(const struct uart *u)
{
    return peripheral_earlier(sent_due(u), received_due(u));
}

static avr_cycle_count_t on_frame_due(avr_t *avr, avr_cycle_count_t when, void *param)
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
        avr_cycle_timer_cancel(u->avr, on_frame_due, u);
    } else {
        peripheral_schedule(u->avr, due, on_frame_due, u);
    }
}

void uart_receive(void *uart, struct bus_frame *frame)
{
    struct uart *u = uart;

    if (u->incoming_last - u->incoming_first < UART_INCOMING) {
        u->incoming[u->incoming_last++ % UART_INCOMING] = frame;
        uart_schedule(u);
    }
}
