// SPDX-License-Identifier: MIT
// The queue of an axis: segments and marks between the bus, which pushes them, and the line
// decoder, which pops them. Both run in the main loop; nothing here may be called from an
// interrupt.
//
//     pop <-- | front | ... | newest |  <-- push        head and tail run freely, modulo 256
//               tail                   head
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/segment.h" // struct segment

struct segment_queue {
    // The memory for the entries; the number of slots is a power of two.
    struct segment *slots;
    // Number of slots - 1.
    uint8_t mask;
    // The slot to write next; the index runs freely and is masked when it is used.
    uint8_t head;
    // The slot to read next; runs freely.
    uint8_t tail;
};

// Make an empty queue in `slots`, which must last as long as the queue. slot_count: a power of two,
// 2..128.
void segment_queue_init(struct segment_queue *queue,
                        struct segment *slots,
                        uint8_t slot_count);
// Number of entries that still fit.
uint8_t segment_queue_free(const struct segment_queue *queue);
// Number of entries that are queued.
uint8_t segment_queue_fill(const struct segment_queue *queue);
// Discard all entries.
void segment_queue_clear(struct segment_queue *queue);

// Append an entry. Returns false and changes nothing when the queue is full.
bool segment_queue_push(struct segment_queue *queue, struct segment segment);
// Remove the front entry and copy it to *segment. Returns false and changes nothing when the queue
// is empty.
bool segment_queue_pop(struct segment_queue *queue, struct segment *segment);

// Copy the entry `ahead` places behind the front (0: the front itself) and leave it in the queue.
// Returns false when there is no such entry.
bool segment_queue_peek(const struct segment_queue *queue,
                        uint8_t ahead,
                        struct segment *segment);
