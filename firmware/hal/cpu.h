// SPDX-License-Identifier: MIT
// The processor itself.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Notes how the processor was reset and stops its watchdog. Call before everything else: general
// purpose registers get their other meanings later.
void cpu_start(void);

void cpu_start_interrupts(void);

// Bits as in input register reset_cause.
uint8_t cpu_reset_cause(void);

// The watchdog resets the processor when it has not been fed for 125 ms (the part's own oscillator:
// 110 to 140). Outputs are then what they are after any reset: STEP low, drivers off, permit off.
void cpu_watchdog_start(void);
void cpu_watchdog_feed(void);

// Nothing on the stack has reached the data below it.
bool cpu_stack_intact(void);

// Address strap read once at reset: 0 none, else the unit address.
uint8_t cpu_address_strap(void);

// Sections of the main loop, for cycle accounting by who watches the processor.
enum cpu_section {
    CPU_SECTION_START = 0,  // before the main loop
    CPU_SECTION_SMOOTH = 1, // decoding
    CPU_SECTION_PLAIN = 2,
    CPU_SECTION_LEDGER = 3, // following what the step interrupts did
    CPU_SECTION_SERIAL = 4, // a look at the serial line, requests and replies
    CPU_SECTION_ROUND = 5,  // the rest of a round: looking for work
};
void cpu_section(enum cpu_section section);
