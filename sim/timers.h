// SPDX-License-Identifier: MIT
//
// All 16-bit timers of a part (timer16.h models one), their input capture pins, and GTCCR, which
// holds their common prescaler.
//
// Rules, from the ATmega328P and ATmega2560 data sheets (GTCCR):
//  * while TSM is set, "the value that is written to the PSRASY and PSRSYNC bits is kept, hence
//    keeping the corresponding prescaler reset signals asserted": the timers stand still, and start
//    together when TSM is cleared.
//  * without TSM, PSRSYNC clears itself at once.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#include "timer16.h"

#define TIMERS_MOST 4

struct timers {
    avr_t *avr;
    int count; // of the part's 16-bit timers
    struct timer16 timer[TIMERS_MOST];
    struct {
        char port;
        uint8_t bit;
    } icp[TIMERS_MOST]; // input capture pin of each timer
};

// Puts the models in place of libsimavr's. Call once, between the part's init and its first reset.
// `hooks` must outlive the timers.
void timers_attach(struct timers *timers, avr_t *avr, const struct timer16_hooks *hooks);

// All timers return to their state after a reset.
void timers_reset(struct timers *timers);

// In all timers, everything that takes effect up to and including this cycle happens now.
void timers_sync(struct timers *timers, uint64_t cycle);

// The timer of this name ('1' for timer 1), NULL if the part has none.
struct timer16 *timers_by_name(struct timers *timers, char name);
