// SPDX-License-Identifier: MIT

#include "serial_log.h"

#include <inttypes.h>
#include <stddef.h>

#include "csv_file.h"

bool serial_log_open(struct serial_log *log, const char *path)
{
    return csv_open(&log->csv, path, "cycle,direction,byte");
}

void serial_log_add(struct serial_log *log, bool sent, uint8_t byte, uint64_t cycle)
{
    if (log->csv != NULL) {
        (void)fprintf(log->csv, "%" PRIu64 ",%s,%02x\n", cycle, sent ? "tx" : "rx", byte);
    }
}

void serial_log_flush(struct serial_log *log)
{
    csv_flush(log->csv);
}

bool serial_log_close(struct serial_log *log)
{
    return csv_close(&log->csv);
}
