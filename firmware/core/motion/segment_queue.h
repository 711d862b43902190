// SPDX-License-Identifier: MIT
// FIFO of segments and marks of one axis. Written and read by the main loop only: no volatile, no lock.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/segment.h" // struct segment

struct segment_queue {
    struct segment *slots; // a power of two of them
    uint8_t mask;          // number of slots - 1
    uint8_t head;          // next to write (free running)
    uint8_t tail;          // next to read (free running)
};

// slot_count: a power of two, 2..128.
void segment_queue_init(struct segment_queue *queue,
                        struct segment *slots,
                        uint8_t slot_count);
uint8_t segment_queue_free(const struct segment_queue *queue);
uint8_t segment_queue_fill(const struct segment_queue *queue);
void segment_queue_clear(struct segment_queue *queue);

// False and unchanged when full / empty.
bool segment_queue_push(struct segment_queue *queue, struct segment segment);
bool segment_queue_pop(struct segment_queue *queue, struct segment *segment);

// The `ahead`-th entry from the front without taking it; false if there is none.
bool segment_queue_peek(const struct segment_queue *queue,
                        uint8_t ahead,
                        struct segment *segment);
