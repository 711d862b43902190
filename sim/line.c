// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "line.h"

#include <string.h>

#include "cpu_clock.h"
// What a receiver still bears: as in uart.c.
#define SPEED_TOLERANCE_PER_MILLE 45

#define RECENT 1024 // frames looked back at for a collision: more than a master may queue

void line_init(struct line *line)
{
    memset(line, 0, sizeof *line);
    line_set_master(line, LINE_BAUD, LINE_EVEN);
    line->master_strict = false;
}

void line_set_master(struct line *line, uint32_t baud, enum line_parity parity)
{
    static const uint8_t formats[] = {
        [LINE_NONE] = 0x06, [LINE_ODD] = 0x36, [LINE_EVEN] = 0x26};

    line->master_baud = baud;
    line->master_format = formats[parity];
    line->master_rest = 0;
    line->master_strict = true;
}

static uint32_t bit_cycles_x1000(const struct line *line)
{
    return (uint32_t)((uint64_t)cpu_clock_hz() * 1000 / line->master_baud);
}

// The stop bit is the idle level: a start bit over it still comes through.
static uint64_t busy_until(const struct line_frame *frame)
{
    return frame->end - frame->bit_cycles_x1000 / 1000;
}

static void collide(struct line *line, struct line_frame *frame)
{
    for (unsigned back = 1; back <= RECENT && back <= line->next_frame; back++) {
        struct line_frame *other = &line->frame[(line->next_frame - back) % LINE_FRAMES];

        if (other->sender != frame->sender && busy_until(other) > frame->start &&
            busy_until(frame) > other->start) {
            other->corrupted = frame->corrupted = true;
            line->corrupted_frames++;
        }
    }
}

struct line_frame *line_start(struct line *line, const struct line_frame *frame)
{
    struct line_frame *kept = &line->frame[line->next_frame % LINE_FRAMES];

    *kept = *frame;
    collide(line, kept);
    line->next_frame++;
    if (line->log != NULL && frame->sender != 0) {
        wire_log_frame(line->log, kept);
    }
    for (int i = 0; i < line->boards; i++) {
        if (i != frame->sender) {
            uart_hear(line->uart[i], kept);
        }
    }
    return kept;
}

uint64_t line_master_send(struct line *line,
                          const uint8_t *bytes,
                          size_t count,
                          uint64_t cycle)
{
    if (line->master_ready < cycle) {
        line->master_ready = cycle;
        line->master_rest = 0;
    }
    for (size_t i = 0; i < count; i++) {
        // Exact bit times on average: the remainder of the division goes into the next frame.
        uint64_t length = (uint64_t)cpu_clock_hz() * LINE_BITS + line->master_rest;
        struct line_frame frame = {
            .start = line->master_ready,
            .end = line->master_ready + length / line->master_baud,
            .bit_cycles_x1000 = bit_cycles_x1000(line),
            .sender = LINE_MASTER,
            .data = bytes[i],
            .format = line->master_format,
        };

        (void)line_start(line, &frame);
        line->master_ready = frame.end;
        line->master_rest = (uint32_t)(length % line->master_baud);
    }
    return line->master_ready;
}

void line_master_pause(struct line *line, uint64_t cycles)
{
    line->master_ready += cycles;
}

static bool fits(const struct line *line, const struct line_frame *frame)
{
    uint32_t mine = bit_cycles_x1000(line);
    uint32_t theirs = frame->bit_cycles_x1000;
    uint32_t off = (mine > theirs) ? mine - theirs : theirs - mine;

    return frame->format == line->master_format &&
           off <= mine / 1000 * SPEED_TOLERANCE_PER_MILLE;
}

static bool heard_well(const struct line *line, const struct line_frame *frame)
{
    return !frame->corrupted && (!line->master_strict || fits(line, frame));
}

int line_master_receive(struct line *line, uint64_t cycle, uint64_t *end)
{
    while (line->heard != line->next_frame) {
        const struct line_frame *frame = &line->frame[line->heard % LINE_FRAMES];

        if (frame->sender == LINE_MASTER) {
            line->heard++;
        } else if (frame->end > cycle) {
            return -1;
        } else {
            line->heard++;
            *end = frame->end;
            return heard_well(line, frame) ? frame->data : (uint8_t)~frame->data;
        }
    }
    return -1;
}

bool line_busy(const struct line *line, uint64_t cycle)
{
    for (unsigned i = line->heard; i != line->next_frame; i++) {
        const struct line_frame *frame = &line->frame[i % LINE_FRAMES];

        if (frame->sender != LINE_MASTER && frame->end > cycle) {
            return true;
        }
    }
    return false;
}
