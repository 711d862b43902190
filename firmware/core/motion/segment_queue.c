// SPDX-License-Identifier: MIT
#include "motion/segment_queue.h"

void run_queue_init(struct run_queue *queue, struct run *slots, uint8_t slot_count)
{
    queue->slots = slots;
    queue->mask = (uint8_t)(slot_count - 1u);
    run_queue_clear(queue);
}

void run_queue_clear(struct run_queue *queue)
{
    queue->head = 0;
    queue->tail = 0;
}

uint8_t run_queue_fill(const struct run_queue *queue)
{
    return (uint8_t)(queue->head - queue->tail);
}

uint8_t run_queue_free(const struct run_queue *queue)
{
    return (uint8_t)(queue->mask + 1u - run_queue_fill(queue));
}

bool run_queue_push(struct run_queue *queue, struct run run)
{
    if (run_queue_free(queue) == 0) {
        return false;
    }
    queue->slots[queue->head & queue->mask] = run;
    queue->head++;
    return true;
}

bool run_queue_peek(const struct run_queue *queue, uint8_t ahead, struct run *run)
{
    if (ahead >= run_queue_fill(queue)) {
        return false;
    }
    *run = queue->slots[(uint8_t)(queue->tail + ahead) & queue->mask];
    return true;
}

bool run_queue_pop(struct run_queue *queue, struct run *run)
{
    if (!run_queue_peek(queue, 0, run)) {
        return false;
    }
    queue->tail++;
    return true;
}
