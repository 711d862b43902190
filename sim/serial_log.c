// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "serial_log.h"

#include <inttypes.h>
#include <stddef.h>

bool serial_log_open(struct serial_log *log, const char *path)
{
    log->csv = NULL;
    if (path == NULL) {
        return true;
    }
    log->csv = fopen(path, "w");
    if (log->csv != NULL) {
        (void)fputs("cycle,direction,byte\n", log->csv);
    }
    return log->csv != NULL;
}

void serial_log_add(struct serial_log *log, bool sent, uint8_t byte, uint64_t cycle)
{
    if (log->csv != NULL) {
        (void)fprintf(log->csv, "%" PRIu64 ",%s,%02x\n", cycle, sent ? "tx" : "rx", byte);
    }
}

void serial_log_flush(struct serial_log *log)
{
    if (log->csv != NULL) {
        (void)fflush(log->csv);
    }
}

bool serial_log_close(struct serial_log *log)
{
    bool written = log->csv == NULL || ferror(log->csv) == 0;

    if (log->csv != NULL && fclose(log->csv) != 0) {
        written = false;
    }
    log->csv = NULL;
    return written;
}
