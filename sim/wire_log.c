// SPDX-License-Identifier: MIT

#include "wire_log.h"

#include <inttypes.h>

#include "csv_file.h"

#define LEVELS_MOST 12 // start, eight data bits, parity, stop, and the text's end

bool wire_log_open(struct wire_log *log, const char *path)
{
    return csv_open(&log->csv, path, "cycle,wire,levels,bit_cycles_x1000");
}

void wire_log_pin(
    struct wire_log *log, char port, unsigned bit, bool level, uint64_t cycle)
{
    if (log->csv != NULL) {
        (void)fprintf(log->csv, "%" PRIu64 ",%c%u,%d,0\n", cycle, port, bit, level);
    }
}

// One character a bit, in the order in which the bits are sent.
static void write_levels(const struct bus_frame *frame, char levels[LEVELS_MOST])
{
    unsigned data_bits = 5U + ((frame->format & BUS_FORMAT_DATA_BITS) >> 1);
    unsigned parity = (frame->format & BUS_FORMAT_ODD_PARITY) != 0 ? 1 : 0;
    unsigned at = 0;

    levels[at++] = '0';
    for (unsigned i = 0; i < data_bits; i++) {
        unsigned bit = (unsigned)frame->data >> i & 1U;

        parity ^= bit;
        levels[at++] = (char)('0' + bit);
    }
    if ((frame->format & BUS_FORMAT_PARITY) != 0) {
        levels[at++] = (char)('0' + parity);
    }
    levels[at++] = '1';
    levels[at] = '\0';
}

void wire_log_frame(struct wire_log *log, const struct bus_frame *frame)
{
    char levels[LEVELS_MOST];

    if (log->csv != NULL) {
        write_levels(frame, levels);
        (void)fprintf(log->csv,
                      "%" PRIu64 ",RXD,%s,%" PRIu32 "\n",
                      frame->start,
                      levels,
                      frame->bit_cycles_x1000);
    }
}

void wire_log_flush(struct wire_log *log)
{
    csv_flush(log->csv);
}

bool wire_log_close(struct wire_log *log)
{
    return csv_close(&log->csv);
}
