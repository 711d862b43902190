// SPDX-License-Identifier: MIT
#include "line/segment_queue.h"

#include <string.h> // memcpy

void segment_queue_init(struct segment_queue *queue, uint8_t *bytes, uint16_t size)
{
    queue->out.bytes = bytes;
    queue->out.mask = (uint16_t)(size - 1u);
    segment_queue_clear(queue);
}

void segment_queue_clear(struct segment_queue *queue)
{
    queue->head = 0;
    queue->last = 0;
    queue->out.at = 0;
    queue->out.last = 0;
}

void segment_queue_append(struct segment_queue *queue,
                          const uint8_t *bytes,
                          uint8_t size,
                          int16_t last)
{
    uint8_t *to = queue->out.bytes;
    uint16_t at = queue->head & queue->out.mask;
    uint16_t to_end = (uint16_t)(queue->out.mask + 1u - at);
    uint16_t first = size < to_end ? size : to_end;

    memcpy(&to[at], bytes, first);
    memcpy(to, &bytes[first], size - first);
    queue->head = (uint16_t)(queue->head + size);
    queue->last = last;
}

bool segment_queue_push(struct segment_queue *queue, struct segment segment)
{
    const uint8_t bytes[SEGMENT_MOST] = {
        (uint8_t)((uint16_t)segment.count >> 8 | SEGMENT_IN_FULL),
        (uint8_t)segment.count,
        (uint8_t)(segment.repeat >> 8),
        (uint8_t)segment.repeat,
    };

    if (segment_queue_free(queue) < SEGMENT_MOST) {
        return false;
    }
    segment_queue_append(queue, bytes, SEGMENT_MOST, segment.count);
    return true;
}

bool segment_queue_pop(struct segment_queue *queue, struct segment *segment)
{
    if (segment_queue_fill(queue) == 0) {
        return false;
    }
    *segment = segment_unpack(&queue->out);
    return true;
}

bool segment_queue_pop_pixels(struct segment_queue *queue, struct segment *segment)
{
    uint16_t at = queue->out.at;
    int16_t last = queue->out.last;

    if (!segment_queue_pop(queue, segment)) {
        return false;
    }
    if (segment->repeat != 0) {
        return true;
    }
    queue->out.at = at;
    queue->out.last = last;
    return false;
}

uint16_t segment_queue_front_word(const struct segment_queue *queue)
{
    const uint8_t *bytes = queue->out.bytes;
    uint16_t mask = queue->out.mask;
    uint16_t at = queue->out.at;

    if (segment_queue_fill(queue) == 0) {
        return 0;
    }
    return (uint16_t)((uint16_t)(bytes[at & mask] & ~SEGMENT_IN_FULL & 0xFFu) << 8 |
                      bytes[(at + 1u) & mask]);
}
