// SPDX-License-Identifier: MIT
#include "promise.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

void promise(bool kept, const char *format, ...)
{
    va_list arguments;

    if (kept) {
        return;
    }
    (void)fputs("broken promise: ", stderr);
    va_start(arguments, format);
    (void)vfprintf(stderr, format, arguments);
    va_end(arguments);
    (void)fputc('\n', stderr);
    abort();
}
