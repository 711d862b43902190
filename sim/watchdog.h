// SPDX-License-Identifier: MIT
//
// Model of the watchdog timer in the place of simavr's, which (1.6) does not set WDE by the timed
// sequence's first write, never resets while WDIE is set, cannot clear WDIF by writing one to it,
// accepts reserved prescalers and restarts its count with every change of the prescaler.
//
//   wdr           wdr                       time-out: WDIF and the interrupt, or a reset
//    |<-  less  ->|<----- 16 ms << WDP ----->|
//
// Rules, from the ATmega328P and ATmega2560 data sheets (Watchdog Timer):
//  * 2048 << WDP cycles of a 128 kHz oscillator: 16 ms << WDP.
//    WDP above 9 is reserved.
//  * "In the same operation, write a logic one to WDCE and WDE. Within the next four clock cycles,
//    write the WDE and WDP bits as desired, but with the WDCE bit cleared." Without this WDE can be
//    set but not cleared, and WDP stays.
//  * WDE = 0, WDIE = 1: each time-out sets WDIF. WDE = 1, WDIE = 0: a time-out resets the part.
//    Both 1: the first sets WDIF; serving the interrupt clears WDIE; "if the interrupt is not
//    executed before the next time-out, a System Reset will be applied".
//  * "WDE is always set when WDRF is set": after a watchdog reset it runs on with WDP = 0, 16 ms,
//    until WDRF is cleared and the sequence turns it off. Any other reset turns it off too, unless
//    WDRF is still set then.
//  * "a change in the WDP bits can result in a time-out when switching to a shorter time-out
//    period": the count goes on; WDR, a start and a time-out restart it.
// Not modelled: the oscillator's tolerance and phase (a count begins with the cycle after WDR), the
// fuse WDTON (unprogrammed, as on Arduino boards), the start-up time after a reset (none).
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <avr_watchdog.h>
#include <sim_avr.h>

#include "peripheral.h"

// WDP = 0: 2048 cycles of 128 kHz.
#define WATCHDOG_SHORTEST_US  16000U
#define WATCHDOG_CHANGE_TICKS 4U

struct watchdog_hooks {
    struct peripheral_host host;
    // The part must be reset as soon as the running instruction has ended.
    void (*reset)(void *board);
};

struct watchdog {
    avr_t *avr;
    avr_watchdog_t *part; // register addresses and the vector, from simavr's description
    const struct watchdog_hooks *hooks;
    uint64_t since;        // the cycle in which the count began
    uint64_t change_until; // WDE and WDP may be changed up to this cycle
};

// Puts the model in place of simavr's. Call once, between the part's init and its first reset.
void watchdog_attach(struct watchdog *watchdog,
                     avr_t *avr,
                     const struct watchdog_hooks *hooks);

// The part was reset; MCUSR must already hold the cause.
void watchdog_reset(struct watchdog *watchdog);

// The program executes WDR now.
void watchdog_restart(struct watchdog *watchdog);
