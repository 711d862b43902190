// SPDX-License-Identifier: MIT
//
// The serial line as a pseudo terminal, paced to real time: any Modbus client can talk to the
// boards.
#pragma once

#include "bench.h"

// Prints the terminal's name and serves it until a board stops or *stop becomes non-zero. Returns
// the exit status.
int pty_serve(struct bench *bench, const volatile int *stop);
