// SPDX-License-Identifier: MIT
//
// The log of the first board's serial port, so that a run can be repeated in another simulator:
//
//   cycle,direction,byte
//   rx   the receiver has the byte at this cycle, when it has decided the stop bit; the byte is as
//        the program will read it, after an overrun or in a damaged frame too
//   tx   the start bit of a byte that the board sends begins at this cycle
//
// A byte is two hexadecimal digits. Frames that end while the receiver is disabled are left out.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct serial_log {
    FILE *csv; // NULL for none
};

// Opens the file (NULL: no log). False with errno set if it cannot be written.
bool serial_log_open(struct serial_log *log, const char *path);

// Adds one byte.
void serial_log_add(struct serial_log *log, bool sent, uint8_t byte, uint64_t cycle);

// Makes the file complete up to now.
void serial_log_flush(struct serial_log *log);

// Closes the file. False if something could not be written.
bool serial_log_close(struct serial_log *log);
