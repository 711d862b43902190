// SPDX-License-Identifier: MIT

#include "peripheral.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TEXT_MOST 200

avr_io_t *peripheral_next(avr_io_t *from, const char *kind)
{
    while (from != NULL && strcmp(from->kind, kind) != 0) {
        from = from->next;
    }
    return from;
}

void peripheral_missing(const char *name)
{
    (void)fprintf(stderr, "pixstep-sim: simavr's part has no %s\n", name);
    abort();
}

void *peripheral_find(const avr_t *avr, const char *kind, const char *name)
{
    avr_io_t *found = peripheral_next(avr->io_port, kind);

    if (found == NULL) {
        peripheral_missing(name);
    }
    return found;
}

void peripheral_raise(const struct peripheral_host *host,
                      avr_t *avr,
                      avr_int_vector_t *vector,
                      uint64_t cycle)
{
    host->flag(host->board, vector->vector, cycle);
    (void)avr_raise_interrupt(avr, vector);
}

void peripheral_refuse(const struct peripheral_host *host, const char *format, ...)
{
    char text[TEXT_MOST];
    va_list arguments;

    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    host->refuse(host->board, text);
}
