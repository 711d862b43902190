// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "line.h"

#include <string.h>

#define RECENT 1024 // frames looked back at for a collision: more than a master may queue

void line_init(struct line *line)
{
    memset(line, 0, sizeof *line);
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
        uint64_t length = (uint64_t)LINE_CPU_HZ * LINE_BITS + line->master_rest;
        struct line_frame frame = {
            .start = line->master_ready,
            .end = line->master_ready + length / LINE_BAUD,
            .bit_cycles_x1000 = (uint32_t)((uint64_t)LINE_CPU_HZ * 1000 / LINE_BAUD),
            .sender = LINE_MASTER,
            .data = bytes[i],
            .format = LINE_FORMAT,
        };

        (void)line_start(line, &frame);
        line->master_ready = frame.end;
        line->master_rest = (uint32_t)(length % LINE_BAUD);
    }
    return line->master_ready;
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
            return frame->corrupted ? (uint8_t)~frame->data : frame->data;
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
