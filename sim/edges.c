// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "edges.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "vcd.h" // vcd_edge

#define FILE_BUFFER (1U << 18)
#define FIRST_ROOM  1024U

const char *edge_signal_name(unsigned signal)
{
    static const char *const names[EDGE_SIGNALS] = {"STEP", "DIR", "ENABLE", "CLOCK"};

    return names[signal];
}

bool edges_open(struct edges *e, const char *csv_path, struct vcd *vcd)
{
    memset(e, 0, sizeof *e);
    e->vcd = vcd;
    if (csv_path != NULL) {
        e->csv = fopen(csv_path, "w");
        if (e->csv == NULL) {
            return false;
        }
        (void)setvbuf(e->csv, NULL, _IOFBF, FILE_BUFFER);
        (void)fputs("cycle,board,axis,signal,level\n", e->csv);
    }
    return true;
}

static void grow(struct edges *e)
{
    size_t room = (e->room == 0) ? FIRST_ROOM : e->room * 2;
    struct edge *waiting = realloc(e->waiting, room * sizeof *waiting);

    if (waiting == NULL) {
        (void)fputs("pixstep-sim: out of memory\n", stderr);
        abort();
    }
    e->waiting = waiting;
    e->room = room;
}

void edges_add(struct edges *e, const struct edge *edge)
{
    size_t at = e->count;

    if (e->csv == NULL && e->vcd == NULL) {
        return;
    }
    if (e->count == e->room) {
        grow(e);
    }
    // Nearly always the newest: a board's own edges come almost in order.
    while (at > 0 && e->waiting[at - 1].cycle > edge->cycle) {
        e->waiting[at] = e->waiting[at - 1];
        at--;
    }
    e->waiting[at] = *edge;
    e->count++;
}

static void write_one(const struct edges *e, const struct edge *edge)
{
    if (e->csv != NULL && edge->signal != EDGE_CLOCK) {
        (void)fprintf(e->csv,
                      "%" PRIu64 ",%u,%u,%s,%u\n",
                      edge->cycle,
                      edge->board,
                      edge->axis,
                      edge_signal_name(edge->signal),
                      edge->level);
    }
    if (e->vcd != NULL) {
        vcd_edge(e->vcd, edge);
    }
}

void edges_settle(struct edges *e, uint64_t cycle)
{
    size_t done = 0;

    while (done < e->count && e->waiting[done].cycle <= cycle) {
        write_one(e, &e->waiting[done]);
        done++;
    }
    if (done > 0) {
        e->count -= done;
        memmove(&e->waiting[0], &e->waiting[done], e->count * sizeof e->waiting[0]);
    }
}

void edges_flush(struct edges *e)
{
    if (e->csv != NULL) {
        (void)fflush(e->csv);
    }
    if (e->vcd != NULL) {
        vcd_flush(e->vcd);
    }
}

bool edges_close(struct edges *e)
{
    bool fine = true;

    edges_settle(e, UINT64_MAX);
    if (e->csv != NULL) {
        fine = ferror(e->csv) == 0;
        fine = fclose(e->csv) == 0 && fine;
    }
    free(e->waiting);
    memset(e, 0, sizeof *e);
    return fine;
}
