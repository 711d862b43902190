// SPDX-License-Identifier: MIT
// Anything at all on the serial line of a whole board: serial line, frame, server, registers,
// queue, motion; natively, as the larger board on the fakes. What must hold, whatever came:
//
//   * one reply to a request for this board, none to anything else; of the right form
//   * a request that is answered with an exception changes no setting
//   * settings stay in their ranges, and no promise inside the firmware is broken
//   * after any input and a silence a valid request is answered
#include <stdlib.h>
#include <string.h>

#include "app/machine.h"
#include "app/round.h"
#include "app/serial.h"
#include "app/settings.h"
#include "fail.h"
#include "fakes/board.h"
#include "fakes/machine_bench.h"
#include "form.h"
#include "script.h"

#define CHARACTER_TICKS ((uint32_t)(CONFIG_TIMER_HZ * 11u / CONFIG_BAUD))
#define SILENCE_TICKS   (CONFIG_SILENCE_4US * 64u + 64u)
#define GAP_TICKS       (SILENCE_TICKS / 2u)
// Until a request is known to be over, served, and its reply sealed.
#define SERVE_ROUNDS (SILENCE_TICKS / BENCH_ROUND_TICKS + 4u)

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

// What came since the line was silent and the board's reply was over.
static uint8_t since_silence[SCRIPT_BYTES_MAX];
static size_t count;
static uint32_t last_byte_ticks;
static unsigned replies;

static void rounds(uint32_t number)
{
    for (; number != 0; number--) {
        fake_pass(BENCH_ROUND_TICKS);
        round_poll();
        serial_poll();
    }
}

static void check_reply(const uint8_t *reply,
                        uint16_t reply_count,
                        const struct settings *before,
                        uint8_t address)
{
    PROMISE(count >= 4 && since_silence[0] == address, "a reply to nobody");
    form_check(since_silence, (uint16_t)count, reply, reply_count);
    if ((reply[1] & 0x80u) != 0) {
        PROMISE(memcmp(&machine.settings, before, sizeof *before) == 0,
                "settings changed by a request that failed");
    }
    replies++;
}

static void check_board(void)
{
    PROMISE(settings_in_range(&machine.settings), "a setting is out of its range");
    PROMISE((machine.fault.mask & (1u << FAULT_internal)) == 0,
            "promise broken at line %u",
            (unsigned)machine.fault.argument);
}

// Until the board has had its say.
static void silence(void)
{
    uint8_t address = (uint8_t)machine.settings.unit_address;
    struct settings before = machine.settings;
    uint8_t reply[FRAME_MAX_BYTES];

    rounds(SERVE_ROUNDS);
    uint16_t sent = fake_sent(reply, sizeof reply);
    if (sent != 0) {
        check_reply(reply, sent, &before, address);
        rounds(sent * CHARACTER_TICKS / BENCH_ROUND_TICKS + 2u);
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
        fake_pass(CHARACTER_TICKS);
        serial_poll();
        last_byte_ticks = fake_now_ticks();
    }
}

// Two of them in a row are a silence.
static void gap(void)
{
    if (fake_now_ticks() + GAP_TICKS - last_byte_ticks < SILENCE_TICKS - CHARACTER_TICKS) {
        rounds(GAP_TICKS / BENCH_ROUND_TICKS);
    } else {
        silence();
    }
}

// Reads a register that every board has.
static void probe(void)
{
    uint8_t request[8] = {(uint8_t)machine.settings.unit_address, 4, 0, 0, 0, 1};
    uint16_t crc = script_crc(request, 6);

    request[6] = (uint8_t)crc;
    request[7] = (uint8_t)(crc >> 8);
    silence();
    unsigned before = replies;
    send(request, sizeof request);
    silence();
    PROMISE(replies == before + 1u, "a valid request was not answered");
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
    serial_start(SCRIPT_ADDRESS);
    count = 0;
    while (script_next(&script, &item)) {
        play(&item);
    }
    probe();
    return 0;
}
