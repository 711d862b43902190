// SPDX-License-Identifier: MIT

#include "csv_file.h"

#define FILE_BUFFER (1U << 18)

bool csv_open(FILE **csv, const char *path, const char *header)
{
    *csv = NULL;
    if (path == NULL) {
        return true;
    }
    *csv = fopen(path, "w");
    if (*csv != NULL) {
        (void)setvbuf(*csv, NULL, _IOFBF, FILE_BUFFER);
        (void)fprintf(*csv, "%s\n", header);
    }
    return *csv != NULL;
}

void csv_flush(FILE *csv)
{
    if (csv != NULL) {
        (void)fflush(csv);
    }
}

bool csv_close(FILE **csv)
{
    bool written = true;

    if (*csv != NULL) {
        written = ferror(*csv) == 0;
        written = fclose(*csv) == 0 && written;
        *csv = NULL;
    }
    return written;
}
