// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.
//
// The control protocol's commands for the serial line and its master.

#include <inttypes.h>
#include <string.h>

#include "control_words.h"
#include "cpu_clock.h"
#include "line.h"

#define PAUSE_US_MAX 10000000U

static void do_send(struct control *c)
{
    struct line *line = &c->bench->line;
    uint64_t pause_us = 0;
    size_t count;

    if (!control_bytes(c, c->word[1], &count) ||
        (c->words > 2 && !control_number(c->word[2], PAUSE_US_MAX, &pause_us))) {
        return;
    }
    (void)line_master_send(line, c->bytes, count, c->bench->cycle);
    line_master_pause(line, cpu_clock_cycles_of_us(pause_us));
    control_answer("ok %" PRIu64, line->master_ready);
}

static void do_baud(struct control *c)
{
    static const char parities[] = "NOE";
    const char *parity = strchr(parities, c->word[2][0]);
    uint64_t baud;

    if (!control_number(c->word[1], LINE_BAUD_MAX, &baud)) {
        return;
    }
    if (baud < LINE_BAUD_MIN || c->word[2][0] == '\0' || parity == NULL ||
        c->word[2][1] != '\0') {
        control_answer("error baud: a rate from %u to %u, and N, O or E",
                       LINE_BAUD_MIN,
                       LINE_BAUD_MAX);
        return;
    }
    line_set_master(
        &c->bench->line, (uint32_t)baud, (enum line_parity)(parity - parities));
    control_answer("ok");
}

const struct command control_line_commands[] = {
    {"send", 2, 3, do_send},
    {"baud", 3, 3, do_baud},
    {NULL, 0, 0, NULL},
};
