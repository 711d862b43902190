// SPDX-License-Identifier: MIT

#include "edges.h"

#include <string.h>

#include "csv_file.h"

#define DIGITS_MAX 20U                   // of a 64-bit number
#define ROW_MAX    (4 * DIGITS_MAX + 16) // four numbers, the longest name, commas

bool edges_open(struct edges *e, const char *csv_path, struct vcd *vcd)
{
    memset(e, 0, sizeof *e);
    e->waiting.row_bytes = sizeof(struct edge);
    e->vcd = vcd;
    return csv_open(&e->csv, csv_path, "cycle,board,axis,signal,level");
}

void edges_add(struct edges *e, const struct edge *edge)
{
    if (e->csv != NULL || e->vcd != NULL) {
        row_queue_add(&e->waiting, edge);
    }
}

// Both append at `at` and return the place behind.
static char *put_text(char *at, const char *text)
{
    while (*text != '\0') {
        *at++ = *text++;
    }
    return at;
}

static char *put_number(char *at, uint64_t number, char after)
{
    char digits[DIGITS_MAX];
    unsigned count = 0;

    do {
        digits[count++] = (char)('0' + number % 10);
        number /= 10;
    } while (number != 0);
    while (count > 0) {
        *at++ = digits[--count];
    }
    *at++ = after;
    return at;
}

// Written by hand: with printf, a run of four fast axes takes a tenth longer.
static void write_csv(FILE *csv, const struct edge *edge)
{
    char row[ROW_MAX];
    char *at = put_number(row, edge->cycle, ',');

    at = put_number(at, edge->board, ',');
    at = put_number(at, edge->axis, ',');
    at = put_text(at, edge_signal_name(edge->signal));
    *at++ = ',';
    at = put_number(at, edge->level, '\n');
    (void)fwrite(row, 1, (size_t)(at - row), csv);
}

static void write_edge(void *param, const void *row)
{
    const struct edges *e = param;
    const struct edge *edge = row;

    if (e->csv != NULL && edge->signal != EDGE_CLOCK) {
        write_csv(e->csv, edge);
    }
    if (e->vcd != NULL) {
        vcd_edge(e->vcd, edge);
    }
}

void edges_settle(struct edges *e, uint64_t cycle)
{
    row_queue_settle(&e->waiting, cycle, write_edge, e);
}

void edges_flush(struct edges *e)
{
    csv_flush(e->csv);
    if (e->vcd != NULL) {
        vcd_flush(e->vcd);
    }
}

bool edges_close(struct edges *e)
{
    edges_settle(e, UINT64_MAX);
    row_queue_free(&e->waiting);
    e->vcd = NULL;
    return csv_close(&e->csv);
}
