// SPDX-License-Identifier: MIT
//
// The power supply and the resets of a part: what each of them keeps and what it initializes.
//
// Rules, from the ATmega328P and ATmega2560 data sheets (System Control and Reset):
//  * MCUSR collects the causes: a power-on leaves PORF alone, every other reset adds its own flag;
//    a program can clear flags, never set them.
//  * registers of the I/O space get their initial values and all pins become inputs. RAM and the
//    general purpose registers keep their content, except through a power cut: then they are noise.
//
//                       RAM, registers   I/O registers   EEPROM              MCUSR
//   external, watchdog  kept             initialized     write goes on       one flag more
//   brown-out           kept             initialized     write goes on       BORF more
//   power off and on    noise            initialized     byte being written  PORF alone
//                                                        becomes random
//
// Not modelled: the start-up time (the program begins at once), the supply's slope.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#include "noise.h"
#include "stack.h"

// Why a part was reset: the flags of MCUSR, by bit.
enum supply_cause {
    SUPPLY_POWER_ON,
    SUPPLY_EXTERNAL,
    SUPPLY_BROWN_OUT,
    SUPPLY_WATCHDOG,
};

// A reset or a change of the supply. Of two that are requested during one instruction, the later in
// this list happens.
enum supply_request {
    SUPPLY_REQUEST_NONE,
    SUPPLY_REQUEST_EXTERNAL, // resets
    SUPPLY_REQUEST_BROWN_OUT,
    SUPPLY_REQUEST_WATCHDOG,
    SUPPLY_REQUEST_OFF,
    SUPPLY_REQUEST_ON,
    SUPPLY_REQUEST_CYCLE, // off and on in the same cycle
};

// What the supply has its board do.
struct supply_hooks {
    void *board;
    // The supply fails now: the EEPROM loses the byte that is being written.
    void (*power_failed)(void *board);
    // Resets the part and all models now. Cold: the supply was away.
    void (*restart)(void *board, bool cold);
    // A request waits: no further instruction may run before supply_fulfil().
    void (*requested)(void *board);
};

struct supply {
    avr_t *avr;
    struct stack_watch *stack;
    const struct supply_hooks *hooks;
    bool powered;                // the program runs only while this is true
    uint8_t mcusr;               // after the next reset
    struct noise noise;          // of RAM after a power cut
    enum supply_request request; // that waits for the end of the instruction
};

// Puts the model of MCUSR in place; the part has power. Call once, between the part's init and its
// first reset. The stack watch must know what RAM holds after a power cut.
void supply_attach(struct supply *supply,
                   avr_t *avr,
                   struct stack_watch *stack,
                   const struct supply_hooks *hooks);

// MCUSR as the reset that is under way leaves it. Call with every reset of the part.
void supply_reset(struct supply *supply);

// Performs a request now, between two instructions. The request must have an effect.
void supply_do(struct supply *supply, enum supply_request request);

// False if the supply is already in that state, or if the part has no power and cannot be reset.
bool supply_has_effect(const struct supply *supply, enum supply_request request);

// Requests something from within an instruction or event; it happens when the instruction has
// ended.
void supply_ask(struct supply *supply, enum supply_request request);

// Performs what was requested, if anything. Call between two instructions.
void supply_fulfil(struct supply *supply);
