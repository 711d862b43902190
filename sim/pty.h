// SPDX-License-Identifier: MIT
//
// The serial bus as a pseudo terminal, paced to real time: any Modbus client can talk to the
// boards.
#pragma once

#include "bench.h"

// Zero means that no terminal is open.
struct pty {
    struct bench *bench;
    int master;           // file descriptor
    double started_s;     // when cycle 0 would have been, at the present pace
    uint64_t lost_cycles; // by which the simulation has fallen behind real time
};

// Offers the bus as a pseudo terminal, in real time from now on. False with errno set if the system
// has none.
bool pty_open(struct pty *pty, struct bench *bench);

bool pty_is_open(const struct pty *pty);

// The terminal's name in the file system.
const char *pty_name(const struct pty *pty);

// Runs everything up to this cycle as bench_run does, but passes on the terminal's bytes and takes
// as long as a board would.
bool pty_run(struct pty *pty, uint64_t cycle);

// Closes the terminal if it is open.
void pty_close(struct pty *pty);

// Prints the terminal's name and serves it until a board stops (exit status 1) or *stop becomes
// non-zero (0). Returns the exit status, 2 if there is no pseudo terminal.
int pty_serve(struct bench *bench, const volatile int *stop);
