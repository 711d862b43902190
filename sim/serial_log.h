// SPDX-License-Identifier: MIT
//
// The log of the first board's serial port, so that a run can be played to another simulator:
//
//   cycle,direction,byte
//   rx   the receiver has the byte at this cycle, when its stop bit is decided; as the program will
//        read it (an overrun or a broken frame shows as what arrived)
//   tx   the start bit of a byte that the board sends begins at this cycle
//
// Bytes are two hexadecimal digits. Frames that end in a disabled receiver are left out.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct serial_log {
    FILE *csv; // NULL for none
};

// Opens the file (NULL: no log). False with errno set if it cannot be written.
bool serial_log_open(struct serial_log *log, const char *path);

void serial_log_add(struct serial_log *log, bool sent, uint8_t byte, uint64_t cycle);

void serial_log_flush(struct serial_log *log);

// False if something could not be written.
bool serial_log_close(struct serial_log *log);
