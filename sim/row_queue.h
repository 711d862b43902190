// SPDX-License-Identifier: MIT
//
// Rows of a log that wait to be put in order. Boards run one after the other within a quantum, so
// rows arrive out of order; at the quantum's end all that belong to it are there.
#pragma once

#include <stddef.h>
#include <stdint.h>

// A queue of rows of one type, a structure whose first member is its uint64_t cycle.
struct row_queue {
    size_t row_bytes; // of that type; the owner sets it, the rest starts as zero
    uint8_t *rows;
    size_t count, room; // in rows
};

// Adds a copy of a row, behind those of the same cycle. Aborts if there is no memory.
void row_queue_add(struct row_queue *queue, const void *row);

// Calls write(param, row) for all rows up to and including this cycle, in the order of their
// cycles, and removes them.
void row_queue_settle(struct row_queue *queue,
                      uint64_t cycle,
                      void (*write)(void *param, const void *row),
                      void *param);

// Forgets all rows and their memory.
void row_queue_free(struct row_queue *queue);
