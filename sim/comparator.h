// SPDX-License-Identifier: MIT
//
// The analog comparator as a source of timer 1's input capture, in the place of simavr's.
//
//   bandgap 1.1 V --(+)                         +--> 2 cycles --> ACSR.ACO, ACI
//                        comparator output -----+
//   ADC pin ------(-)      1: pin is low        +--> ACIC = 1 --+
//   MUX5, MUX2:0                                                +--> timer 1's input capture
//                                     ICP1 pin -----> ACIC = 0 -+
//
// Rules, from the ATmega328P and ATmega2560 data sheets (Analog Comparator; Input Capture Unit):
//  * with ACME = 1, ADEN = 0 and PRADC = 0 the ADC's multiplexer chooses the negative input: MUX2:0
//    and, on the ATmega2560, MUX5. Pins are digital here: low is 0 V, high is 5 V, and a pin that
//    nobody drives is what its pull-up makes of it.
//  * "The comparator output is directly connected to the input capture front-end logic", which
//    samples it as it does ICP1: TIMER16_ICP_SYNC_CYCLES from the pin's edge to ICR1, edge select
//    and noise canceler as for ICP1. Only timer 1 has this; while ACIC is set, ICP1 captures
//    nothing.
//  * "changing trigger source can trigger a capture": where the level at the front end changes with
//    a write to ACSR, ADMUX and the rest, that is an edge like any other, in the cycle after the
//    write.
//  * ACO is synchronized in 1 to 2 cycles; an edge exactly on a clock edge takes 2. ACI follows ACO
//    as ACIS1:0 say.
// Not modelled: the time that the comparator itself takes (some 0.5 us), the bandgap's start
// (70 us at most, when the brown-out detector is off), its interrupt, and all other inputs. With
// other inputs ACO reads 0 (a read while the set-up is not yet complete must be harmless);
// capturing with them, or enabling the interrupt, is refused.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#include "peripheral.h"
#include "ports.h"

#define COMPARATOR_ACO_CYCLES 2
#define COMPARATOR_SHARED     4 // registers

struct comparator_hooks {
    struct peripheral_host host;
    // From this cycle on, the comparator's output may be another, or timer 1 may or may not capture
    // it.
    void (*changed)(void *board, uint64_t cycle);
};

struct comparator {
    avr_t *avr;
    const struct ports *ports;
    const struct comparator_hooks *hooks;
    struct {
        avr_io_write_t write; // simavr's own, for the registers that the ADC shares
        void *param;
    } before[COMPARATOR_SHARED];

    bool output, output_before; // now, and until output_cycle
    uint64_t output_cycle;
    bool flagged; // the last change of the output sets ACI, once ACO shows it
    // The pin of the negative input; port is 0 while that is not an ADC pin against the bandgap.
    char port;
    uint8_t bit;
};

// Puts the model in place of simavr's. Call once, between the part's init and its first reset. The
// model reads the level of its pin from `ports`.
void comparator_attach(struct comparator *comparator,
                       avr_t *avr,
                       const struct ports *ports,
                       const struct comparator_hooks *hooks);

// The part was reset: the comparator is on, compares AIN0 with AIN1 and captures nothing.
void comparator_reset(struct comparator *comparator);

// Pins of this port may have changed level at this cycle.
void comparator_follow(struct comparator *comparator, char port, uint64_t cycle);

// ACIC: timer 1's input capture listens to the comparator.
bool comparator_captures(const struct comparator *comparator);
