// SPDX-License-Identifier: MIT
//
// A log: a CSV file of rows behind a header. A log that was not asked for is NULL everywhere.
#pragma once

#include <stdbool.h>
#include <stdio.h>

// Opens the file and writes the header's line. *csv is NULL if path is: no log. False with errno
// set if the file cannot be written.
bool csv_open(FILE **csv, const char *path, const char *header);

// Writes what is buffered.
void csv_flush(FILE *csv);

// Closes the file; *csv is NULL afterwards. False if something could not be written.
bool csv_close(FILE **csv);
