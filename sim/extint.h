// SPDX-License-Identifier: MIT
//
// Model of the external interrupts INT0 and up in the place of simavr's, which (1.6) sets a flag of
// EIFR that the program writes one to, does not raise a flag that waited when its interrupt is
// enabled, and polls every low pin in every cycle while the sense bits are 0 (as after a reset).
//
//   pin     ______/-------
//                 |<- 3 ->|
//   INTFn   ______________/----       by ISCn1:0: 1 any edge, 2 falling, 3 rising
//
// Rules, from the ATmega328P and ATmega2560 data sheets (External Interrupts):
//  * INTFn is set by the edge whether or not INTn is enabled; "the flag is cleared when the
//    interrupt routine is executed", or by writing one to it.
//  * "the interrupts will trigger even if the INT pins are configured as outputs".
//  * TAKEN FROM the pin change interrupts' timing diagram, for want of one of its own: an edge
//    exactly on a clock edge sets the flag three cycles later. Two edges within these three cycles
//    are one request.
// Refused: an enabled interrupt with ISCn1:0 = 0 (low level).
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <avr_extint.h>
#include <sim_avr.h>

#include "peripheral.h"
#include "ports.h"

#define EXTINT_SYNC_CYCLES 3U
#define EXTINT_NEVER       UINT64_MAX

struct extint {
    avr_t *avr;
    avr_extint_t *part; // register addresses and vectors, from simavr's description
    const struct peripheral_host *host;
    const struct ports *ports;
    int lines;
    uint32_t listening; // ports that have such pins: bit 0 for port A
    struct {            // by number of the interrupt
        char port;
        uint8_t bit;
        bool level;        // as seen last
        uint64_t flag_due; // INTFn comes up; EXTINT_NEVER if no edge is under way
    } line[EXTINT_COUNT];
};

// Puts the model in place of simavr's. Call once, between the part's init and its first reset. The
// model reads the levels of its pins from `ports`.
void extint_attach(struct extint *extint,
                   avr_t *avr,
                   const struct peripheral_host *host,
                   const struct ports *ports);

// The part was reset: no interrupt is enabled and no flag is due. Call after ports_reset().
void extint_reset(struct extint *extint);

// Pins of this port, which has such pins, may have changed level at this cycle.
void extint_pins_changed(struct extint *extint, char port, uint64_t cycle);

// The same for any port.
static inline void extint_follow(struct extint *extint, char port, uint64_t cycle)
{
    if ((extint->listening >> (unsigned)(port - 'A') & 1U) != 0) {
        extint_pins_changed(extint, port, cycle);
    }
}
