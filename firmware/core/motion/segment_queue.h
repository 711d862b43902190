// SPDX-License-Identifier: MIT
// FIFO of runs and marks of one axis. Written and read by the main loop only: no volatile, no lock.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/segment.h" // struct run

struct run_queue {
    struct run *slots; // a power of two of them
    uint8_t mask;      // number of slots - 1
    uint8_t head;      // next to write (free running)
    uint8_t tail;      // next to read (free running)
};

// slot_count: a power of two, 2..128.
void run_queue_init(struct run_queue *queue, struct run *slots, uint8_t slot_count);
uint8_t run_queue_free(const struct run_queue *queue);
uint8_t run_queue_fill(const struct run_queue *queue);
void run_queue_clear(struct run_queue *queue);

// False and unchanged when full / empty.
bool run_queue_push(struct run_queue *queue, struct run run);
bool run_queue_pop(struct run_queue *queue, struct run *run);

// The `ahead`-th entry from the front without taking it; false if there is none.
bool run_queue_peek(const struct run_queue *queue, uint8_t ahead, struct run *run);
