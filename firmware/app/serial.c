// SPDX-License-Identifier: MIT
#include "app/serial.h"

#include <stdbool.h>

#include "app/machine.h" // machine.settings
#include "config.h"      // CONFIG_SILENCE_4US
#include "hal/clock.h"   // clock_now_4us
#include "hal/uart.h"    // uart_*
#include "wire/frame.h"  // struct frame

// Receives into the frame, turns it into the reply in place, sends it from there.
static struct frame frame;
static struct server_counters counters;
static uint16_t overruns;
static uint16_t last_request_ms;
static uint32_t last_byte_4us;
static bool serve_pending; // a request is complete; the reply waits for silence
static bool replying;
static uint16_t to_seal_bytes; // a reply that still lacks its checksum

void serial_start(uint8_t address)
{
    if (address != 0) {
        machine.settings.unit_address = address;
    }
    uart_start();
    frame_reset(&frame);
}

const struct server_counters *serial_counters(void)
{
    return &counters;
}

uint16_t serial_overruns(void)
{
    return overruns;
}

static void take_status(enum frame_status status)
{
    if (status == FRAME_READY) {
        serve_pending = true;
    } else if (status == FRAME_BAD) {
        counters.crc_errors++;
    }
}

// Bytes that arrive while a request is being served belong to nobody.
static void receive(void)
{
    uint8_t byte = 0;

    while (uart_take(&byte)) {
        last_byte_4us = clock_now_4us();
        if (!serve_pending && !replying) {
            take_status(frame_byte(&frame, byte, (uint8_t)machine.settings.unit_address));
        }
    }
}

uint16_t serial_last_request_ms(void)
{
    return last_request_ms;
}

static void serve(void)
{
    last_request_ms = clock_now_ms();
    serve_pending = false;
    to_seal_bytes = server_serve(&frame, &counters);
    if (to_seal_bytes != 0) {
        replying = true;
    } else {
        frame_reset(&frame);
    }
}

// The checksum in a round of its own: motion waits for the longer of the two only.
static void seal(void)
{
    uint16_t length = frame_seal(&frame, to_seal_bytes);

    to_seal_bytes = 0;
    uart_send(frame.bytes, length);
}

// Looked at before new bytes are: the next request may follow before this round was reached.
static void finish_reply(void)
{
    if (replying && to_seal_bytes == 0 && !uart_sending()) {
        replying = false;
        frame_reset(&frame);
        last_byte_4us = clock_now_4us();
    }
}

void serial_poll(void)
{
    overruns = (uint16_t)(overruns + uart_take_overruns());
    finish_reply();
    receive();
    if (to_seal_bytes != 0) {
        seal();
    }
    if (replying || clock_now_4us() - last_byte_4us < CONFIG_SILENCE_4US) {
        return;
    }
    if (!serve_pending) {
        take_status(frame_silence(&frame, (uint8_t)machine.settings.unit_address));
    }
    if (serve_pending) {
        serve();
    }
}
