// SPDX-License-Identifier: MIT

#include "control_bus.h"

#include "cpu_clock.h"

#include <inttypes.h>
#include <string.h>

#define PAUSE_US_MAX 10000000U

static void do_send(struct control *c)
{
    struct bus *bus = &c->bench->bus;
    uint64_t pause_us = 0;
    size_t count;

    if (!control_bytes(c, c->word[1], &count) ||
        (c->words > 2 && !control_number(c->word[2], PAUSE_US_MAX, &pause_us))) {
        return;
    }
    (void)bus_master_send(bus, c->bytes, count, c->bench->cycle);
    bus_master_pause(bus, cpu_clock_cycles_of_us(pause_us));
    control_answer("ok %" PRIu64, bus->master_ready);
}

static void do_baud(struct control *c)
{
    static const char parities[] = "NOE";
    const char *parity = strchr(parities, c->word[2][0]);
    uint64_t baud;

    if (!control_number(c->word[1], BUS_BAUD_MAX, &baud)) {
        return;
    }
    if (baud < BUS_BAUD_MIN || c->word[2][0] == '\0' || parity == NULL ||
        c->word[2][1] != '\0') {
        control_answer("error baud: a rate from %u to %u, and N, O or E",
                       BUS_BAUD_MIN,
                       BUS_BAUD_MAX);
        return;
    }
    bus_set_master(&c->bench->bus, (uint32_t)baud, (enum bus_parity)(parity - parities));
    control_answer("ok");
}

const struct command control_bus_commands[] = {
    {"send", 2, 3, do_send},
    {"baud", 3, 3, do_baud},
    {NULL, 0, 0, NULL},
};
