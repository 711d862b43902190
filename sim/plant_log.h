// SPDX-License-Identifier: MIT
//
// The log of the mechanics, in steps:
//
//   cycle,board,axis,motor,load
//
// The first row of every axis that was given a plant is where motor and load start; one row follows
// whenever the motor has moved. A step against a hard stop moves neither.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "row_queue.h"

struct plant_row {
    uint64_t cycle; // first, as struct row_queue needs it
    int64_t motor, load;
    uint8_t board, axis;
};

struct plant_log {
    FILE *csv;                // NULL for none
    struct row_queue waiting; // struct plant_row
};

// Opens the file (NULL: no log). False with errno set if it cannot be written.
bool plant_log_open(struct plant_log *log, const char *path);

// Adds a row, which may be some cycles earlier than others.
void plant_log_add(struct plant_log *log, const struct plant_row *row);

// No row up to and including this cycle can still come: writes them, in the order of their cycles.
void plant_log_settle(struct plant_log *log, uint64_t cycle);

// Makes the file complete up to the last settled cycle.
void plant_log_flush(struct plant_log *log);

// Settles everything and closes the file. False if something could not be written.
bool plant_log_close(struct plant_log *log);
