// SPDX-License-Identifier: MIT
// The input registers that show the board's state, everything except the arrays of data.c. Main
// loop only.
//
//     docs/PROTOCOL.md    the meaning and the unit of each register
//     registers.def       the addresses
//     report.c            a table: for each address, where its value comes from
//
// Every value is taken when its register is read; nothing here is kept up to date between requests.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Bits of input register `status`.
// The pixel clock's newest edge is known and the clock does not rest.
#define REPORT_CLOCK 0x0001u
// An axis is armed, with or without a known line zero.
#define REPORT_ARMED 0x0002u
// An axis runs.
#define REPORT_RUNNING 0x0004u
// A fault is latched.
#define REPORT_FAULT 0x0008u
// The emergency stop is pressed.
#define REPORT_ESTOP 0x0010u
// The permit is switched on.
#define REPORT_PERMIT 0x0020u
// The server is in listen-only mode (function 08, sub-function 4).
#define REPORT_LISTEN_ONLY 0x0040u
#define REPORT_STOPPING    0x0100u // axis 0, and the next bits the next axes

// The input register at this address, which must be mapped (data_input_mapped()). Where a 32-bit
// value may change between the reads of its two words, reading the first word takes the sample that
// the second word completes; read both in one request, in order.
uint16_t report_word(uint16_t address);

// Input register `status`: REPORT_* bits.
uint16_t report_status(void);
