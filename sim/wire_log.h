// SPDX-License-Identifier: MIT
//
// The log of everything that reaches the first board from outside, so that another simulator can be
// given the same signals (sim/crosscheck):
//
//   cycle,wire,levels,bit_cycles_x1000
//   160000,B0,1,0                  pin PB0 is driven to this level from this cycle on
//   800000,RXD,01000001011,138888  a frame begins: its levels from the start bit to the stop bit,
//                                  and the length of each, in thousandths of a cycle
//
// Rows come in the order in which the simulator learns of them, a frame before its cycle. A frame
// that meets another one is logged as it was sent.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "bus_frame.h"

struct wire_log {
    FILE *csv; // NULL for none
};

// Opens the file (NULL: no log). False with errno set if it cannot be written.
bool wire_log_open(struct wire_log *log, const char *path);

// A pin is driven to this level.
void wire_log_pin(
    struct wire_log *log, char port, unsigned bit, bool level, uint64_t cycle);

// A frame starts on the bus.
void wire_log_frame(struct wire_log *log, const struct bus_frame *frame);

// Makes the file complete up to now.
void wire_log_flush(struct wire_log *log);

// Closes the file. False if something could not be written.
bool wire_log_close(struct wire_log *log);
