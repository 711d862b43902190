// SPDX-License-Identifier: MIT
//
// The program's view of UART 0: its registers.

#include <string.h>

#include "access.h"
#include "uart.h"
#include "uart_bits.h"

static void write_udr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct uart *u = param;

    (void)address;
    uart_sync(u, access_cycle(avr));
    if ((uart_ucsrb(u) & TXEN) == 0 || u->waiting) {
        return; // the part ignores it: the transmitter is off, or UDRE0 is not set
    }
    if (u->shifting) {
        u->waiting = true;
        u->waiting_data = value;
        uart_follow_levels(u);
        return;
    }
    uart_start_frame(u, value, access_cycle(avr) + 1);
    uart_schedule(u);
}

static uint8_t read_udr(avr_t *avr, avr_io_addr_t address, void *param)
{
    struct uart *u = param;

    (void)address;
    uart_sync(u, access_cycle(avr));
    if (u->fifo_count > 0) {
        u->rx_last = u->fifo[0].data;
        u->fifo_count--;
        memmove(&u->fifo[0], &u->fifo[1], (size_t)u->fifo_count * sizeof u->fifo[0]);
        u->overrun = false;
        uart_follow_levels(u);
    }
    return u->rx_last;
}

static uint8_t read_ucsra(avr_t *avr, avr_io_addr_t address, void *param)
{
    struct uart *u = param;
    uint8_t kept;

    uart_sync(u, access_cycle(avr));
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
        peripheral_refuse(&u->hooks->host,
                          "UART 0: multi-processor mode is not modelled");
    }
    uart_sync(u, access_cycle(avr));
    if ((value & TXC) != 0) {
        avr_clear_interrupt(avr, &u->part->txc);
    }
    avr->data[address] = (uint8_t)((avr->data[address] & TXC) | (value & U2X));
    uart_schedule(u); // the speed may have changed
}

static void write_ucsrb(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct uart *u = param;

    avr->data[address] = value;
    if ((value & UCSZ2) != 0) {
        peripheral_refuse(&u->hooks->host, "UART 0: 9 data bits are not modelled");
    }
    if ((value & RXEN) == 0) {
        u->fifo_count = 0; // "disabling the receiver will flush the receive buffer"
        u->overrun = false;
    }
    uart_follow_levels(u);
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
        peripheral_refuse(&u->hooks->host, "UART 0: synchronous modes are not modelled");
    }
    avr->data[address] = value;
    uart_schedule(u);
}

static void write_ubrr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    avr->data[address] = value;
    uart_schedule(param);
}

void uart_reset(struct uart *u)
{
    uart_driver_off(u, u->avr->cycle);
    u->shifting = u->waiting = false;
    u->outgoing = NULL;
    u->fifo_count = 0;
    u->overrun = false;
    u->rx_last = 0;
    u->avr->data[u->part->r_ucsra] = 0;
    u->avr->data[u->part->r_ucsrb] = 0;
    u->avr->data[u->part->r_ucsrc] = 0x06; // the part's initial value: 8 data bits
    uart_schedule(u);
}

static avr_uart_t *find_uart_0(avr_t *avr)
{
    for (avr_io_t *io = peripheral_next(avr->io_port, "uart"); io != NULL;
         io = peripheral_next(io->next, "uart")) {
        avr_uart_t *part = (avr_uart_t *)(void *)io;

        if (part->name == '0') {
            return part;
        }
    }
    peripheral_missing("UART 0");
}

void uart_attach(struct uart *u,
                 avr_t *avr,
                 struct bus *bus,
                 int index,
                 const struct own_time *time,
                 const struct uart_hooks *hooks)
{
    avr_uart_t *part = find_uart_0(avr);

    u->avr = avr;
    u->part = part;
    u->hooks = hooks;
    u->bus = bus;
    u->index = index;
    u->time = time;
    u->incoming_first = u->incoming_begun = u->incoming_last = 0;
    access_take(avr, part->r_udr, read_udr, write_udr, u);
    access_take(avr, part->r_ucsra, read_ucsra, write_ucsra, u);
    access_take(avr, part->r_ucsrb, NULL, write_ucsrb, u);
    access_take(avr, part->r_ucsrc, NULL, write_ucsrc, u);
    access_take(avr, part->ubrrl.reg, NULL, write_ubrr, u);
    access_take(avr, part->ubrrh.reg, NULL, write_ubrr, u);
}
