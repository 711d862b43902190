// SPDX-License-Identifier: MIT
// A board without hardware on standard input and output: the firmware's bus port, server, registers
// and queues, natively, on the suites' fakes. The program speaks as much of the simulator's control
// protocol as a Modbus client needs, and shows the contents of the queues:
//
//   run CYCLES           ok CYCLE         let time pass
//   tx HEX [TIMEOUT]     rx HEX CYCLE     send, then wait for the reply's end (rx -: no reply)
//   pop AXIS             runs C,R C,R ... empty an axis's queue, as its decoder does
//   quit                 ok
//
// The program accepts the options of the simulator's command line and ignores them.
#include <inttypes.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/bus/bus_port.h"
#include "app/round.h"
#include "config.h"
#include "fakes/board.h"
#include "fakes/board_bench.h"

#define ADDRESS 1u
#define ROUND_TICKS                                                                      \
    8000u // shorter than a silence on the bus, so that no silence is missed
#define CHARACTER_TICKS ((uint32_t)(CONFIG_TIMER_HZ * 11u / 115200uL))
#define CHUNK           8u // characters between two looks
#define SILENCE_TICKS   28032u
#define LINE_MAX        8192u

static uint64_t cycle;

static void pass(uint32_t ticks)
{
    fake_pass(ticks);
    cycle += ticks;
    round_poll();
    bus_port_poll();
}

static void run(uint64_t cycles)
{
    for (; cycles > ROUND_TICKS; cycles -= ROUND_TICKS) {
        pass(ROUND_TICKS);
    }
    pass((uint32_t)cycles);
}

// Send the bytes of a row of hexadecimal digits; false if the row is malformed.
static bool send_hex(const char *digits)
{
    size_t length = strspn(digits, "0123456789abcdefABCDEF");
    unsigned since_look = 0;

    if (length == 0 || length % 2 != 0) {
        return false;
    }
    for (size_t i = 0; i < length; i += 2) {
        const char pair[3] = {digits[i], digits[i + 1], '\0'};
        uint8_t byte = (uint8_t)strtoul(pair, NULL, 16);

        fake_receive(&byte, 1);
        since_look++;
        if (since_look == CHUNK || i + 2 == length) {
            pass(since_look * CHARACTER_TICKS);
            since_look = 0;
        }
    }
    return true;
}

// Take the board's reply. When there is none, at least a silence passes.
static uint16_t take_reply(const uint8_t **reply)
{
    uint16_t sent = 0;

    for (uint32_t waited = 0; waited < 2u * SILENCE_TICKS && sent == 0;
         waited += ROUND_TICKS) {
        pass(ROUND_TICKS);
        sent = fake_sent(reply);
    }
    return sent;
}

static void do_tx(const char *words)
{
    const uint8_t *reply = NULL;

    if (!send_hex(words)) {
        (void)puts("error not a row of bytes");
        return;
    }
    uint16_t sent = take_reply(&reply);

    (void)fputs("rx ", stdout);
    for (uint16_t i = 0; i < sent; i++) {
        (void)printf("%02x", reply[i]);
    }
    if (sent != 0) {
        run(sent * CHARACTER_TICKS + SILENCE_TICKS);
    }
    (void)printf("%s %" PRIu64 "\n", sent == 0 ? "-" : "", cycle);
}

static void do_run(const char *words)
{
    run(strtoull(words, NULL, 10));
    (void)printf("ok %" PRIu64 "\n", cycle);
}

static void do_pop(const char *words)
{
    unsigned long axis = strtoul(words, NULL, 10);
    struct segment entry;

    if (axis >= CONFIG_AXES) {
        (void)puts("error no such axis");
        return;
    }
    (void)fputs("runs", stdout);
    while (segment_queue_pop(&axes_get((uint8_t)axis)->queue, &entry)) {
        (void)printf(" %d,%u", entry.count, entry.repeat);
    }
    (void)putchar('\n');
}

int main(void)
{
    static char line[LINE_MAX];

    bench_power_on();
    settings_override_address(ADDRESS);
    bus_port_start();
    while (fgets(line, sizeof line, stdin) != NULL && strncmp(line, "quit", 4) != 0) {
        if (strncmp(line, "tx ", 3) == 0) {
            do_tx(line + 3);
        } else if (strncmp(line, "run ", 4) == 0) {
            do_run(line + 4);
        } else if (strncmp(line, "pop ", 4) == 0) {
            do_pop(line + 4);
        } else {
            (void)puts("error unknown command");
        }
        (void)fflush(stdout);
    }
    (void)puts("ok");
    return 0;
}
