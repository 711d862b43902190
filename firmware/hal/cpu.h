// SPDX-License-Identifier: MIT
// The processor itself: reset, watchdog, stack. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Note how the processor was reset, and stop its watchdog. Call it before everything else, because
// general purpose registers get other meanings later.
void cpu_start(void);

// Enable interrupts.
void cpu_start_interrupts(void);

// Cause of the last reset; bits as in input register reset_cause.
uint8_t cpu_reset_cause(void);

// Start the watchdog, which resets the processor when it has not been fed for 125 ms (110 to 140
// ms, because the watchdog has an oscillator of its own). A reset leaves STEP low, drivers off and
// permit off.
void cpu_watchdog_start(void);
// Restart the watchdog's time.
void cpu_watchdog_feed(void);

// True while the stack has not reached the data below it.
bool cpu_stack_intact(void);

// The address strap as it was at reset: 0 none, else the unit address.
uint8_t cpu_address_strap(void);

// Sections of the main loop, for a simulator or a probe that accounts for cycles.
enum cpu_section {
    CPU_SECTION_START = 0,  // before the main loop
    CPU_SECTION_SMOOTH = 1, // decoding
    CPU_SECTION_PLAIN = 2,
    // Following what the step interrupts did.
    CPU_SECTION_LEDGER = 3,
    // Polling the bus, requests and replies.
    CPU_SECTION_SERIAL = 4,
    // The rest of a round.
    CPU_SECTION_ROUND = 5,
    // What cannot wait for the end of a request.
    CPU_SECTION_INTERLUDE = 6,
    // Decoding, or following, is over: the section from which it was called goes on.
    CPU_SECTION_CALLER = 7,
};
// The main loop enters this section.
void cpu_section(enum cpu_section section);
