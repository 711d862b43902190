// SPDX-License-Identifier: MIT

#include "plant_log.h"

#include <inttypes.h>
#include <string.h>

#include "csv_file.h"

bool plant_log_open(struct plant_log *log, const char *path)
{
    memset(log, 0, sizeof *log);
    log->waiting.row_bytes = sizeof(struct plant_row);
    return csv_open(&log->csv, path, "cycle,board,axis,motor,load");
}

void plant_log_add(struct plant_log *log, const struct plant_row *row)
{
    if (log->csv != NULL) {
        row_queue_add(&log->waiting, row);
    }
}

static void write_position(void *csv, const void *row)
{
    const struct plant_row *position = row;

    (void)fprintf(csv,
                  "%" PRIu64 ",%u,%u,%" PRId64 ",%" PRId64 "\n",
                  position->cycle,
                  (unsigned)position->board,
                  (unsigned)position->axis,
                  position->motor,
                  position->load);
}

void plant_log_settle(struct plant_log *log, uint64_t cycle)
{
    row_queue_settle(&log->waiting, cycle, write_position, log->csv);
}

void plant_log_flush(struct plant_log *log)
{
    csv_flush(log->csv);
}

bool plant_log_close(struct plant_log *log)
{
    plant_log_settle(log, UINT64_MAX);
    row_queue_free(&log->waiting);
    return csv_close(&log->csv);
}
