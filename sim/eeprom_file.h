// SPDX-License-Identifier: MIT
//
// The content of an EEPROM in a file: its bytes, nothing else.
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "eeprom.h"

// Loads the content from a file; bytes beyond the file's end are erased, and so is the whole EEPROM
// if there is no such file yet. False, with one line in `error`, if the file cannot be read or is
// too long, or if it could not be created later.
bool eeprom_load(struct eeprom *eeprom, const char *path, char *error, size_t room);

// Writes the content into a file: all of it, or nothing. False with errno set.
bool eeprom_save(const struct eeprom *eeprom, const char *path);
