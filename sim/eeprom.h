// SPDX-License-Identifier: MIT
//
// Model of the EEPROM in the place of simavr's, which (1.6) writes in no time, never shows EEPE,
// lets EE_READY come once only, halts the CPU for no cycle and takes every address.
//
//   EEMPE = 1    EEPE = 1                                     EEPE = 0
//      |<-- 4 -->|  |<-- 2 -->|                                   |
//      window       CPU halted                                    |
//                   |<------------- being programmed ------------>|-> EE_READY, for as long as
//                                                                     EERIE = 1 and EEPE = 0
//
// Rules, from the ATmega328P and ATmega2560 data sheets (EEPROM Data Memory):
//  * "When EEMPE is set, setting EEPE within four clock cycles will write data to the EEPROM at the
//    selected address. If EEMPE is zero, setting EEPE will have no effect."
//  * EEPM1:0: 0 erases and writes in 3.4 ms, 1 erases only, 2 writes only (can clear bits, never
//    set them), each in 1.8 ms. "While EEPE is set, any write to EEPMn will be ignored."
//  * after EEPE the CPU is halted for two cycles, after EERE for four.
//  * "If a write operation is in progress, it is neither possible to read the EEPROM, nor to change
//    the EEAR Register": EEAR keeps its value.
//  * EE_READY "generates a constant interrupt when EEPE is cleared".
//  * "If a reset occurs while a write operation is in progress, the write operation will be
//    completed provided that the power supply voltage is sufficient": it goes on through every
//    reset, and a brown-out counts as sufficient (2.7 V; the EEPROM works from 1.8 V on). Only a
//    power cut ends it: the byte is then anything.
// Refused, because the data sheets tell programs to wait first and do not say what happens
// otherwise: reading, starting a write or changing EEDR while one is in progress; EEPM1:0 = 3; EERE
// and EEPE at once. Not modelled: the tolerance of the oscillator behind the times.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <avr_eeprom.h>
#include <sim_avr.h>

#include "noise.h"
#include "peripheral.h"

#define EEPROM_BYTES_MOST   4096
#define EEPROM_ERASED       0xFFU
#define EEPROM_BOTH_US      3400U
#define EEPROM_HALF_US      1800U
#define EEPROM_EERIE        0x08U // in EECR
#define EEPROM_ENABLE_TICKS 4U

struct eeprom {
    avr_t *avr;
    avr_eeprom_t *part; // register addresses and the vector, from simavr's description
    const struct peripheral_host *host;
    uint8_t bytes[EEPROM_BYTES_MOST];
    uint16_t size;
    struct noise noise; // of what a power cut leaves

    uint64_t enabled_until; // EEPE starts a write up to this cycle
    bool busy;
    uint64_t started, due; // of the write in progress
    uint16_t address;
    uint8_t value, mode;
    uint64_t writes; // begun by the program so far
};

// Puts the model in place of simavr's, erased. Call once, between the part's init and its first
// reset.
void eeprom_attach(struct eeprom *eeprom, avr_t *avr, const struct peripheral_host *host);

// The part was reset. A write in progress goes on.
void eeprom_reset(struct eeprom *eeprom);

// The power fails at this cycle: the byte being written is anything, the others are as they were.
void eeprom_power_cut(struct eeprom *eeprom, uint64_t cycle);

// EE_READY is a level: raises or takes back the interrupt as the registers demand.
void eeprom_follow_level(struct eeprom *eeprom, uint64_t cycle);

// The same, for a call after every service of an interrupt: cheap while EERIE is 0.
static inline void eeprom_served(struct eeprom *eeprom)
{
    if ((eeprom->avr->data[eeprom->part->r_eecr] & EEPROM_EERIE) != 0) {
        eeprom_follow_level(eeprom, eeprom->avr->cycle);
    }
}
