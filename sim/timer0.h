// SPDX-License-Identifier: MIT
//
// Compare B of timer 0 in the place of libsimavr's, while the timer counts freely (mode 0) at
// clk/64; libsimavr keeps the count and its overflow.
//
// Rules, from the ATmega328P and ATmega2560 data sheets (8-bit timer 0):
//  * a match "will set the output compare flag at the next timer clock cycle", and changes the
//    output in the same cycle as COM0B1:0 say then. The output keeps its level between matches.
//  * in mode 0 OCR0B has no buffer: it counts from the cycle after the write on.
//
// Refused: compare B in another mode or at another prescaler, and force compare.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <avr_timer.h>
#include <sim_avr.h>

#include "peripheral.h"

struct timer0_hooks {
    struct peripheral_host host;
    // Compare output B has a new level, or was connected or disconnected, at this cycle.
    void (*output)(void *board, uint64_t cycle);
};

struct timer0 {
    avr_t *avr;
    avr_timer_t *part;
    const struct timer0_hooks *hooks;
    avr_io_write_t start; // libsimavr's own callbacks of TCCR0B
    void *start_param;
    uint8_t ocr;   // OCR0B
    uint64_t due;  // cycle of the next match's effect, 0 for none
    bool oc_level; // of compare output B
};

// Puts the model in place of libsimavr's. Call once, between the part's init and its first reset.
void timer0_attach(struct timer0 *timer, avr_t *avr, const struct timer0_hooks *hooks);

// The state after a reset.
void timer0_reset(struct timer0 *timer);

// Compare output B takes the pin from the port.
bool timer0_is_connected(const struct timer0 *timer);
