// SPDX-License-Identifier: MIT
#include "motion/segment_queue.h"

void segment_queue_init(struct segment_queue *queue,
                        struct segment *slots,
                        uint8_t slot_count)
{
    queue->slots = slots;
    queue->mask = (uint8_t)(slot_count - 1u);
    segment_queue_clear(queue);
}

void segment_queue_clear(struct segment_queue *queue)
{
    queue->head = 0;
    queue->tail = 0;
}

uint8_t segment_queue_fill(const struct segment_queue *queue)
{
    return (uint8_t)(queue->head - queue->tail);
}

uint8_t segment_queue_free(const struct segment_queue *queue)
{
    return (uint8_t)(queue->mask + 1u - segment_queue_fill(queue));
}

bool segment_queue_push(struct segment_queue *queue, struct segment segment)
{
    if (segment_queue_free(queue) == 0) {
        return false;
    }
    queue->slots[queue->head & queue->mask] = segment;
    queue->head++;
    return true;
}

bool segment_queue_peek(const struct segment_queue *queue,
                        uint8_t ahead,
                        struct segment *segment)
{
    if (ahead >= segment_queue_fill(queue)) {
        return false;
    }
    *segment = queue->slots[(uint8_t)(queue->tail + ahead) & queue->mask];
    return true;
}

bool segment_queue_pop(struct segment_queue *queue, struct segment *segment)
{
    if (!segment_queue_peek(queue, 0, segment)) {
        return false;
    }
    queue->tail++;
    return true;
}
