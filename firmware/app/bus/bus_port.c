// SPDX-License-Identifier: MIT
#include "app/bus/bus_port.h"

#include <stdbool.h>

#include "app/bus/traffic.h"       // traffic_*
#include "app/settings/settings.h" // settings_*
#include "base/apart.h"            // APART
#include "config.h"                // CONFIG_TIMER_HZ
#include "hal/clock.h"             // clock_now_units
#include "hal/uart.h"              // uart_*
#include "wire/baud.h"             // baud_*
#include "wire/frame.h"            // struct frame
#include "wire/register_map.h"     // REG_QUEUE_WINDOW

_Static_assert(FRAME_ROOM_BYTES == UART_BUFFER_BYTES, "the port receives into the frame");
_Static_assert(CONFIG_TIMER_HZ / 8u == BAUD_CLOCK_100 * 100uL,
               "the clock that divisors are counted in");

// The checksum of a frame up to this long takes no time worth a round of its own.
#define SHORT_BYTES 32u

// The one buffer of the bus: a request is received here, its reply replaces it and is sent from
// here.
static struct frame bus_frame;

// A request to this board alone is answered before the board receives again: bytes that come before
// the reply has left are discarded. Bytes behind any other frame begin the next frame.
static enum phase {
    LISTENING,
    REQUESTED, // a request is complete and waits for the silence behind it
    ANSWERED,  // the reply is made, without its checksum, and waits for its delay
    SENDING,
} phase;
static uint8_t reply_bytes;
static uint16_t reply_since_units; // start of the reply's delay

static void apply_bus_settings(void)
{
    baud_counts divisor = baud_divisor(settings_now()->baud_100);

    uart_set(
        divisor, (enum uart_parity)settings_now()->parity, baud_silence_counts(divisor));
}

void bus_port_start(void)
{
    frame_reset(&bus_frame);
    uart_start(bus_frame.bytes);
    apply_bus_settings();
    phase = LISTENING;
}

static void serve_request(void)
{
    struct server_counters *counters = traffic_counters();

    // In listen-only mode no request is executed, so that for a moving axis the bus counts as
    // silent.
    if (!server_listens_only(counters)) {
        traffic_note_request();
    }
    reply_bytes = server_serve(&bus_frame, counters);
}

// Receive again; changed settings of the bus take effect now.
static void resume_listening(void)
{
    apply_bus_settings();
    phase = LISTENING;
}

// Take a complete frame, if there is one. A broadcast is served at once, because the next frame may
// follow without silence.
static void take_frame(void)
{
    bool ended = uart_received(&bus_frame.received);
    enum frame_status status =
        frame_look(&bus_frame, ended, (uint8_t)settings_now()->unit_address);
    uint16_t length = bus_frame.length;
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
        if (bus_frame.bytes[0] != 0) {
            phase = REQUESTED;
            return;
        }
        serve_request();
        apply_bus_settings();
    }
    uart_drop(length);
}

static void build_reply(void)
{
    uart_disable_reception();
    serve_request();
    reply_since_units = (uint16_t)clock_now_units();
    phase = ANSWERED;
    if (reply_bytes == 0) {
        uart_enable_reception();
        resume_listening();
    }
}

// Send the reply when its delay is over. The checksum of a long one is computed in another round
// than the reply, so that motion waits for one of the two at a time.
static void send_reply(void)
{
    uint16_t waited_units = (uint16_t)((uint16_t)clock_now_units() - reply_since_units);

    if (waited_units >= clock_units_of_us(settings_now()->reply_delay_us)) {
        uart_send(frame_seal(&bus_frame, reply_bytes));
        phase = SENDING;
    }
}

static inline void answer(void)
{
    if (phase == ANSWERED) {
        send_reply();
    } else if (phase == REQUESTED && uart_silent()) {
        build_reply();
        // A round of several axes takes milliseconds: a host that asks often would wait for most of
        // them.
        if (CONFIG_AXES > 1 && phase == ANSWERED && reply_bytes <= SHORT_BYTES) {
            send_reply();
        }
    }
}

APART void bus_port_poll(void)
{
    traffic_count_overruns(uart_take_overruns());
    if (phase == SENDING && !uart_sending()) {
        resume_listening();
    }
    // Take one frame a round: at fast rates a buffer full of short frames would keep the watchdog
    // waiting. The checksum of a long request takes a round, too.
    if (phase == LISTENING) {
        take_frame();
        if (phase == REQUESTED && bus_frame.length > SHORT_BYTES) {
            return;
        }
    }
    answer();
}

#if SEVERAL_AXES
// How a request that brings entries of lines begins, behind the address: function 16, and the high
// byte of the queue window.
#define WRITE_MANY        16u
#define QUEUE_WINDOW_HIGH (REG_QUEUE_WINDOW >> 8)

// The frame brings entries of lines, or is the reply to such a request, which begins with the same
// bytes.
static inline bool is_block(void)
{
    return bus_frame.bytes[1] == WRITE_MANY && bus_frame.bytes[2] >= QUEUE_WINDOW_HIGH;
}

bool bus_port_brings_data(void)
{
    return is_block() &&
           (phase == ANSWERED || (phase != SENDING && uart_holds() && uart_silent()));
}
#endif
