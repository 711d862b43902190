// SPDX-License-Identifier: MIT
// The input registers that show the machine: everything but the arrays of data.c. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define REPORT_CLOCK       0x0001u // bits of input register `status`
#define REPORT_ARMED       0x0002u
#define REPORT_RUNNING     0x0004u
#define REPORT_FAULT       0x0008u
#define REPORT_ESTOP       0x0010u
#define REPORT_PERMIT      0x0020u
#define REPORT_LISTEN_ONLY 0x0040u
#define REPORT_STOPPING    0x0100u // axis 0, and the next bits the next axes

uint16_t report_word(uint16_t address);

// Input register `status`.
uint16_t report_status(void);
