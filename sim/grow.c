// SPDX-License-Identifier: MIT

#include "grow.h"

#include <stdio.h>
#include <stdlib.h>

void *grow(void *array, size_t *room, size_t first, size_t size)
{
    size_t more = (*room == 0) ? first : *room * 2;
    void *larger = realloc(array, more * size);

    if (larger == NULL) {
        (void)fputs("pixstep-sim: out of memory\n", stderr);
        abort();
    }
    *room = more;
    return larger;
}
