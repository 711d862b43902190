// SPDX-License-Identifier: MIT

#include "plant_log.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "csv_file.h"

#define FIRST_ROOM 256U

bool plant_log_open(struct plant_log *log, const char *path)
{
    memset(log, 0, sizeof *log);
    return csv_open(&log->csv, path, "cycle,board,axis,motor,load");
}

static void grow(struct plant_log *log)
{
    size_t room = (log->room == 0) ? FIRST_ROOM : log->room * 2;
    struct plant_row *waiting = realloc(log->waiting, room * sizeof *waiting);

    if (waiting == NULL) {
        (void)fputs("pixstep-sim: out of memory\n", stderr);
        abort();
    }
    log->waiting = waiting;
    log->room = room;
}

void plant_log_add(struct plant_log *log, const struct plant_row *row)
{
    size_t at = log->count;

    if (log->csv == NULL) {
        return;
    }
    if (log->count == log->room) {
        grow(log);
    }
    while (at > 0 && log->waiting[at - 1].cycle > row->cycle) {
        log->waiting[at] = log->waiting[at - 1];
        at--;
    }
    log->waiting[at] = *row;
    log->count++;
}

static void write_row(FILE *csv, const struct plant_row *row)
{
    (void)fprintf(csv,
                  "%" PRIu64 ",%u,%u,%" PRId64 ",%" PRId64 "\n",
                  row->cycle,
                  (unsigned)row->board,
                  (unsigned)row->axis,
                  row->motor,
                  row->load);
}

void plant_log_settle(struct plant_log *log, uint64_t cycle)
{
    size_t done = 0;

    while (done < log->count && log->waiting[done].cycle <= cycle) {
        write_row(log->csv, &log->waiting[done]);
        done++;
    }
    if (done > 0) {
        log->count -= done;
        memmove(
            &log->waiting[0], &log->waiting[done], log->count * sizeof log->waiting[0]);
    }
}

void plant_log_flush(struct plant_log *log)
{
    csv_flush(log->csv);
}

bool plant_log_close(struct plant_log *log)
{
    plant_log_settle(log, UINT64_MAX);
    bool fine = csv_close(&log->csv);
    free(log->waiting);
    memset(log, 0, sizeof *log);
    return fine;
}
