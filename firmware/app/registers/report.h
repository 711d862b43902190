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
#define REPORT_CLOCK       0x0001u // the pixel clock runs (reference_present())
#define REPORT_ARMED       0x0002u // an axis is armed, line zero known or not
#define REPORT_RUNNING     0x0004u // an axis runs
#define REPORT_FAULT       0x0008u // a fault is latched
#define REPORT_ESTOP       0x0010u // the emergency stop is pressed
#define REPORT_PERMIT      0x0020u // the permit is switched on
#define REPORT_LISTEN_ONLY 0x0040u // the server is in listen-only mode
#define REPORT_SETTLED     0x0080u // lines can be locked to the pixel clock
#define REPORT_STOPPING    0x0100u // axis 0 is stopping, and the next bits the next axes
// Axis 0 began its newest line with backlash without knowing its play, and the next bits the next.
#define REPORT_PLAY 0x1000u

// The input register at this address, which must be mapped (data_input_mapped()). Where a 32-bit
// value may change between the reads of its two words, reading the first word takes the sample that
// the second word completes; read both in one request, in order.
uint16_t report_word(uint16_t address);

// The first of `count` (1..125) input registers from `address` on, big-endian: up to the last one
// of the board's first registers, of those in front of an axis's position, of the axis, or of the
// board's others. Returns their number. An interlude comes before a position, before each axis and
// before those others. A board of several axes only: quicker than one by one.
uint8_t report_words(uint16_t address, uint8_t count, uint8_t *to);

// Input register `status`: REPORT_* bits.
uint16_t report_status(void);
