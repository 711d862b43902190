// SPDX-License-Identifier: MIT
#include "app/serial.h"

#include <stdbool.h>

#include "app/settings.h" // settings_*
#include "app/traffic.h"  // traffic_*
#include "config.h"       // CONFIG_TIMER_HZ
#include "hal/clock.h"    // clock_now_units
#include "hal/uart.h"     // uart_*
#include "wire/baud.h"    // baud_*
#include "wire/frame.h"   // struct frame

_Static_assert(FRAME_ROOM_BYTES == UART_BUFFER_BYTES, "the line receives into the frame");
_Static_assert(CONFIG_TIMER_HZ / 8u == BAUD_CLOCK_100 * 100uL, "the line's clock");

// Received in place, turned into the reply in place, sent from there.
static struct frame frame;

// A request to this board alone is answered before the line is listened to again: what comes before
// the silence that the reply waits for, behind the request, and what comes until the reply has left
// belongs to nobody. What follows any other frame is the next one.
static enum phase {
    LISTENING,
    REQUESTED, // waits for silence
    ANSWERED,  // waits for the reply's delay, without its checksum
    SENDING,
} phase;
static uint8_t reply_bytes;
static uint16_t since_units; // the reply's delay runs

static void set_line(void)
{
    baud_counts divisor = baud_divisor(settings_now()->baud_100);

    uart_set(
        divisor, (enum uart_parity)settings_now()->parity, baud_silence_counts(divisor));
}

void serial_start(void)
{
    frame_reset(&frame);
    uart_start(frame.bytes);
    set_line();
    phase = LISTENING;
}

static void serve(void)
{
    struct server_counters *counters = traffic_counters();

    // In listen-only mode no request is executed: the bus is silent for what moves.
    if (!counters->listen_only) {
        traffic_note_request();
    }
    reply_bytes = server_serve(&frame, counters);
}

// Settings of the line count from here on.
static void listen(void)
{
    set_line();
    phase = LISTENING;
}

// A frame that is over, if there is one. One to all is served at once: the next frame may follow it
// without silence.
static void take_frame(void)
{
    bool ended = uart_received(&frame.received);
    enum frame_status status =
        frame_look(&frame, ended, (uint8_t)settings_now()->unit_address);
    uint16_t length = frame.length;
    struct server_counters *counters = traffic_counters();
    uint16_t *counter = &counters->bus_messages;

    if (status == FRAME_PARTIAL) {
        return;
    }
    if (status == FRAME_BAD) {
        counter = &counters->crc_errors;
    }
    (*counter)++;
    if (status == FRAME_READY) {
        if (frame.bytes[0] != 0) {
            phase = REQUESTED;
            return;
        }
        serve();
        set_line();
    }
    uart_drop(length);
}

static void answer(void)
{
    uart_deafen();
    serve();
    since_units = (uint16_t)clock_now_units();
    phase = ANSWERED;
    if (reply_bytes == 0) {
        uart_listen();
        listen();
    }
}

// The checksum in a round of its own: motion waits for the longer of the two only.
static void send(void)
{
    uint16_t waited_units = (uint16_t)((uint16_t)clock_now_units() - since_units);

    if (waited_units >= clock_units_of_us(settings_now()->reply_delay_us)) {
        uart_send(frame_seal(&frame, reply_bytes));
        phase = SENDING;
    }
}

void serial_poll(void)
{
    traffic_count_overruns(uart_take_overruns());
    if (phase == SENDING && !uart_sending()) {
        listen();
    }
    // One a round: a buffer full of short ones would keep the watchdog waiting at fast rates.
    if (phase == LISTENING) {
        take_frame();
    }
    if (phase == ANSWERED) {
        send();
    } else if (phase == REQUESTED && uart_silent()) {
        answer();
    }
}
