// SPDX-License-Identifier: MIT
// The queue of an axis: segments and marks between the bus, which pushes them, and the line
// decoder, which pops them. The entries are packed (segment_pack.h), so that a queue holds four
// times as many pixels with counts of their own as it holds runs. Both ends are in the main loop;
// nothing here may be called from an interrupt.
//
//     pop <-- | front | ... | newest |  <-- push        head and tail run freely, modulo 65536
//               out.at               head
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "line/segment_pack.h" // struct segment_reader

struct segment_queue {
    // The reader's end: segment_source.c pops, the assembly of whole pixels too.
    struct segment_reader out;
    // The writer's end: the byte to write next; the index runs freely and is masked when it is
    // used.
    uint16_t head;
    // Count of the newest entry, from which the next packed entry goes on; 0 in a cleared queue.
    int16_t last;
};

// Make an empty queue in `bytes`, which must last as long as the queue. size: bytes, a power of
// two, 8..32768.
void segment_queue_init(struct segment_queue *queue, uint8_t *bytes, uint16_t size);
// Discard all entries.
void segment_queue_clear(struct segment_queue *queue);

// Number of bytes that are queued, 0..size.
static inline uint16_t segment_queue_fill(const struct segment_queue *queue)
{
    return (uint16_t)(queue->head - queue->out.at);
}

// Number of bytes that still fit.
static inline uint16_t segment_queue_free(const struct segment_queue *queue)
{
    return (uint16_t)(queue->out.mask + 1u - segment_queue_fill(queue));
}

// Number of entries that surely fit.
static inline uint16_t segment_queue_free_entries(const struct segment_queue *queue)
{
    return segment_queue_free(queue) / SEGMENT_MOST;
}

// Append an entry in full. Returns false and changes nothing when fewer than SEGMENT_MOST bytes are
// free. The count is stored with 15 bits.
bool segment_queue_push(struct segment_queue *queue, struct segment segment);
// Append `size` bytes of whole packed entries, packed from the queue's `last` on. The caller has
// made sure that there is room. last: the count of the last of the entries.
void segment_queue_append(struct segment_queue *queue,
                          const uint8_t *bytes,
                          uint8_t size,
                          int16_t last);
// Remove the front entry and copy it to *segment. Returns false and changes nothing when the queue
// is empty.
bool segment_queue_pop(struct segment_queue *queue, struct segment *segment);
// As segment_queue_pop(), but a mark at the front stays there: the result is then false too, and
// *segment is a copy of the mark.
bool segment_queue_pop_pixels(struct segment_queue *queue, struct segment *segment);
// The word of the start mark at the front, which stays there; 0 when the queue is empty. The front
// entry must be a start mark, which is always in full.
uint16_t segment_queue_front_word(const struct segment_queue *queue);
