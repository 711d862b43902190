// SPDX-License-Identifier: MIT
//
// The serial bus as a pseudo terminal, paced to real time: any Modbus client can talk to the
// boards.
#pragma once

#include "bench.h"

// Prints the terminal's name and serves it until a board stops (exit status 1) or *stop becomes
// non-zero (0). Returns the exit status, 2 if there is no pseudo terminal.
int pty_serve(struct bench *bench, const volatile int *stop);
