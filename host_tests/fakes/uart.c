// SPDX-License-Identifier: MIT
// A fake of hal/uart.h: bytes arrive at the instant at which a suite gives them, and a reply leaves
// at the rate of the bus.
#include "hal/uart.h"

#include <string.h>

#include "fakes/board.h"
#include "fakes/board_parts.h"

#define TICKS_PER_COUNT 256u
#define TICKS_PER_BIT   8u // for each count of the divisor

struct fake_line fake_line;

static uint8_t *buffer;
static uint16_t received; // bytes in the buffer
static uint16_t gap; // number of bytes before the first silence among them, 0: no silence
static bool deaf;
static uint8_t overruns;
static uint32_t last_byte_ticks;
static uint16_t outgoing_length;
static uint32_t sent_at_ticks;
static bool sending;

void fake_uart_power_on(void)
{
    received = 0;
    gap = 0;
    overruns = 0;
    outgoing_length = 0;
    sending = false;
    deaf = false;
    last_byte_ticks = fake_now_ticks();
    fake_line = (struct fake_line){0, UART_NONE, 0, 0};
}

static void receive(uint8_t byte)
{
    if (uart_silent() && gap == 0 && received < UART_BUFFER_BYTES) {
        gap = received;
    }
    last_byte_ticks = fake_now_ticks();
    if (received < UART_BUFFER_BYTES) {
        buffer[received] = byte;
        received++;
    }
}

void fake_receive(const uint8_t *bytes, uint16_t length)
{
    for (uint16_t i = 0; !deaf && i < length; i++) {
        receive(bytes[i]);
    }
}

void fake_overrun(uint8_t bytes)
{
    overruns = (uint8_t)(overruns + bytes);
}

uint16_t fake_sent(const uint8_t **bytes)
{
    uint16_t length = outgoing_length;

    *bytes = buffer;
    outgoing_length = 0;
    return length;
}

void uart_enable_reception(void)
{
    received = 0;
    gap = 0;
    deaf = false;
}

void uart_start(uint8_t *bytes)
{
    buffer = bytes;
    uart_enable_reception();
}

void uart_set(uart_divisor divisor, enum uart_parity parity, uint16_t silence_counts)
{
    if (divisor != fake_line.divisor || parity != fake_line.parity) {
        fake_line = (struct fake_line){
            divisor, (uint8_t)parity, silence_counts, (uint8_t)(fake_line.changes + 1u)};
    }
}

bool uart_silent(void)
{
    return fake_now_ticks() - last_byte_ticks >=
           (uint32_t)fake_line.silence_counts * TICKS_PER_COUNT;
}

uint32_t uart_age_ticks(void)
{
    return fake_now_ticks() - last_byte_ticks;
}

bool uart_holds(void)
{
    return received != 0;
}

bool uart_received(uint16_t *count)
{
    *count = gap != 0 ? gap : received;
    return gap != 0 || uart_silent();
}

void uart_drop(uint16_t count)
{
    received = (uint16_t)(received - count);
    memmove(buffer, buffer + count, received);
    gap = gap > count ? (uint16_t)(gap - count) : 0;
}

void uart_disable_reception(void)
{
    deaf = true;
}

uint8_t uart_take_overruns(void)
{
    uint8_t count = overruns;

    overruns = 0;
    return count;
}

void uart_send(uint16_t length)
{
    outgoing_length = length;
    sent_at_ticks =
        fake_now_ticks() + 11u * TICKS_PER_BIT * (uint32_t)fake_line.divisor * length;
    sending = true;
}

bool uart_sending(void)
{
    if (sending && (int32_t)(fake_now_ticks() - sent_at_ticks) >= 0) {
        sending = false;
        uart_enable_reception();
    }
    return sending;
}
