// SPDX-License-Identifier: MIT
// Any bytes on the bus of a whole board: bus port, frame, server, registers, queue, motion;
// natively, as the larger board on the fakes. After any input this must hold:
//
//   * a request for this board gets one reply of the right form, anything else gets none
//   * a request that is answered with an exception changes no setting
//   * settings stay in their ranges, and no promise inside the firmware is broken
//   * after a silence a valid request is answered
#include <stddef.h>
#include <string.h>

#include "app/bus/bus_port.h"
#include "app/bus/traffic.h"
#include "app/round.h"
#include "app/settings/settings.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "form.h"
#include "promise.h"
#include "script.h"
#include "target.h"
#include "wire/frame.h"

// Ticks of a round: the main loop is slow, so that most of the time goes into rounds.
#define ROUND_TICKS    6000u
#define TICKS_PER_16US 256u
#define TICKS_PER_US   16u
#define TICKS_PER_BIT  8u // for each count of the divisor
#define CHARACTER_BITS 11u
#define READ_INPUT     4u
#define DIAGNOSE       8u
#define RESTART        1u

// The bytes since the bus was last silent and the board's reply had left.
static uint8_t since_silence[SCRIPT_BYTES_MAX];
static size_t count;
static uint32_t last_byte_ticks;
static unsigned replies;

// The silence that ends a frame, by the present settings of the bus.
static uint32_t silence_ticks(void)
{
    return (uint32_t)fake_line.silence_counts * TICKS_PER_16US;
}

static uint32_t character_ticks(void)
{
    return (uint32_t)fake_line.divisor * TICKS_PER_BIT * CHARACTER_BITS;
}

static void pass(uint32_t ticks)
{
    for (uint32_t passed = 0; passed < ticks; passed += ROUND_TICKS) {
        fake_pass(ROUND_TICKS);
        round_poll();
        bus_port_poll();
    }
}

// The number of bytes of the shortest frame at the front of these bytes; 0: no frame.
static size_t whole_frame(const uint8_t *bytes, size_t number)
{
    for (size_t length = 4; length <= number && length <= FRAME_MAX_BYTES; length++) {
        if (script_crc(bytes, length) == 0) {
            return length;
        }
    }
    return 0;
}

// The request that a reply belongs to: at the front, or behind whole frames for other boards or for
// all boards.
static const uint8_t *asked(uint8_t address)
{
    size_t from = 0;

    while (from + 4u <= count) {
        size_t length = whole_frame(&since_silence[from], count - from);
        if (length == 0 || since_silence[from] == address) {
            return length != 0 ? &since_silence[from] : NULL;
        }
        from += length;
    }
    return NULL;
}

static void check_reply(const uint8_t *reply,
                        uint16_t reply_count,
                        const struct settings *before,
                        uint8_t address)
{
    const uint8_t *request = asked(address);

    promise(request != NULL, "a reply to nobody");
    form_check(request, reply, reply_count);
    if ((reply[1] & 0x80u) != 0) {
        promise(memcmp(bench_settings(), before, sizeof *before) == 0,
                "settings changed by a request that failed");
    }
    replies++;
}

static void check_board(void)
{
    promise(settings_are_possible(), "a setting is out of its range");
    promise((faults_record()->mask & (1u << FAULT_internal)) == 0,
            "promise broken at line %u",
            (unsigned)faults_record()->argument);
}

// Let time pass until the board's reply has left, and check the reply.
static void silence(void)
{
    uint8_t address = (uint8_t)bench_settings()->unit_address;
    struct settings before = *settings_now();
    const uint8_t *reply = NULL;

    // The board takes one frame a round, and the shortest frame has four bytes. The reply is
    // delayed by the setting as it is after the request, which may have changed it.
    pass(silence_ticks() + (2u + (uint32_t)count / 4u) * ROUND_TICKS);
    pass(bench_settings()->reply_delay_us * TICKS_PER_US + 2u * ROUND_TICKS);
    uint16_t sent = fake_sent(&reply);
    if (sent != 0) {
        check_reply(reply, sent, &before, address);
        pass(sent * character_ticks() + 2u * ROUND_TICKS);
    }
    check_board();
    count = 0;
}

static void send(const uint8_t *bytes, size_t number)
{
    for (size_t i = 0; i < number; i++) {
        if (count < sizeof since_silence) {
            since_silence[count] = bytes[i];
            count++;
        }
        fake_receive(&bytes[i], 1);
        fake_pass(character_ticks());
        bus_port_poll();
        last_byte_ticks = fake_now_ticks();
    }
}

// Let a part of a silence pass; two parts in a row are a silence.
static void gap(void)
{
    uint32_t half_ticks = silence_ticks() / 2u;

    if (fake_now_ticks() - last_byte_ticks < half_ticks / 2u) {
        pass(half_ticks);
    } else {
        silence();
    }
}

static void ask(uint8_t function, uint8_t second)
{
    uint8_t request[8] = {
        (uint8_t)bench_settings()->unit_address, function, 0, second, 0, 0};

    request[5] = function == READ_INPUT ? 1 : 0;
    uint16_t crc = script_crc(request, 6);

    request[6] = (uint8_t)crc;
    request[7] = (uint8_t)(crc >> 8);
    send(request, sizeof request);
    silence();
}

// End listen-only mode, then read a register that every board has.
static void probe(void)
{
    silence();
    if (traffic_counters()->listen_only) {
        ask(DIAGNOSE, RESTART);
    }
    unsigned before = replies;
    ask(READ_INPUT, 0);
    promise(replies == before + 1u, "a valid request was not answered");
}

static void play(const struct script_item *item)
{
    if (item->kind == SCRIPT_PROBE) {
        probe();
        return;
    }
    if (item->kind == SCRIPT_GAP) {
        gap();
        return;
    }
    if (item->kind == SCRIPT_SILENCE || item->silence_before) {
        silence();
    }
    send(item->bytes, item->count);
    if (item->count != 0 && item->silence_after) {
        silence();
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct script script = {.data = data, .left = size};
    struct script_item item;

    bench_power_on();
    settings_override_address(SCRIPT_ADDRESS);
    bus_port_start();
    count = 0;
    while (script_next(&script, &item)) {
        play(&item);
    }
    probe();
    return 0;
}
