// SPDX-License-Identifier: MIT
// hal/uart.h: bytes wait until they are taken; a reply leaves at line speed.
#include "hal/uart.h"

#include <string.h>

#include "fakes/board.h"
#include "fakes/board_parts.h"

#define INCOMING_MAX    64u
#define CHARACTER_TICKS ((uint32_t)(CONFIG_TIMER_HZ * 11u / CONFIG_BAUD))

static uint8_t incoming[INCOMING_MAX];
static uint8_t taken;
static uint8_t received;
static uint8_t overruns;
static const uint8_t *outgoing;
static uint16_t outgoing_length;
static uint32_t sent_at_ticks;
static bool sending;

void fake_uart_power_on(void)
{
    taken = 0;
    received = 0;
    overruns = 0;
    outgoing_length = 0;
    sending = false;
}

void fake_receive(const uint8_t *bytes, uint16_t length)
{
    if (taken == received) {
        taken = 0;
        received = 0;
    }
    for (uint16_t i = 0; i < length; i++) {
        if (received == INCOMING_MAX) {
            overruns++;
        } else {
            incoming[received] = bytes[i];
            received++;
        }
    }
}

uint16_t fake_sent(uint8_t *bytes, uint16_t room)
{
    uint16_t length = outgoing_length < room ? outgoing_length : room;

    if (length != 0) {
        memcpy(bytes, outgoing, length);
    }
    outgoing_length = 0;
    return length;
}

void uart_start(void)
{
}

bool uart_take(uint8_t *byte)
{
    if (taken == received) {
        return false;
    }
    *byte = incoming[taken];
    taken++;
    return true;
}

uint8_t uart_take_overruns(void)
{
    uint8_t count = overruns;

    overruns = 0;
    return count;
}

void uart_send(const uint8_t *bytes, uint16_t length)
{
    outgoing = bytes;
    outgoing_length = length;
    sent_at_ticks = fake_now_ticks() + CHARACTER_TICKS * length;
    sending = true;
}

bool uart_sending(void)
{
    if (sending && (int32_t)(fake_now_ticks() - sent_at_ticks) >= 0) {
        sending = false;
    }
    return sending;
}
