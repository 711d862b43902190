// SPDX-License-Identifier: MIT

#include "row_queue.h"

#include <stdlib.h>
#include <string.h>

#include "grow.h"

#define FIRST_ROOM 1024U

static uint8_t *row_at(const struct row_queue *q, size_t index)
{
    return &q->rows[index * q->row_bytes];
}

static uint64_t cycle_of(const void *row)
{
    uint64_t cycle;

    memcpy(&cycle, row, sizeof cycle);
    return cycle;
}

void row_queue_add(struct row_queue *q, const void *row)
{
    size_t at = q->count;

    if (q->count == q->room) {
        q->rows = grow(q->rows, &q->room, FIRST_ROOM, q->row_bytes);
    }
    // Nearly always the newest: the rows of one board come almost in order.
    while (at > 0 && cycle_of(row_at(q, at - 1)) > cycle_of(row)) {
        at--;
    }
    memmove(row_at(q, at + 1), row_at(q, at), (q->count - at) * q->row_bytes);
    memcpy(row_at(q, at), row, q->row_bytes);
    q->count++;
}

void row_queue_settle(struct row_queue *q,
                      uint64_t cycle,
                      void (*write)(void *param, const void *row),
                      void *param)
{
    size_t done = 0;

    while (done < q->count && cycle_of(row_at(q, done)) <= cycle) {
        write(param, row_at(q, done));
        done++;
    }
    if (done > 0) {
        q->count -= done;
        memmove(row_at(q, 0), row_at(q, done), q->count * q->row_bytes);
    }
}

void row_queue_free(struct row_queue *q)
{
    free(q->rows);
    q->rows = NULL;
    q->count = q->room = 0;
}
