// SPDX-License-Identifier: MIT
//
// A file of rows behind a header, as the logs are. NULL stands for no log everywhere.
#pragma once

#include <stdbool.h>
#include <stdio.h>

// Opens the file (path NULL: no log, *csv is NULL) and writes the header's line. False with errno
// set if it cannot be written.
bool csv_open(FILE **csv, const char *path, const char *header);

void csv_flush(FILE *csv);

// False if something could not be written. *csv is NULL afterwards.
bool csv_close(FILE **csv);
