// SPDX-License-Identifier: MIT
//
// The pins of a part: what its program writes to PORTx and DDRx, and what drives them from outside.
// A pin reads its own output if it is one, else what drives it from outside, else its pull-up.
//
//   DDRx bit   driven from outside   the pin reads
//   1          either                PORTx bit
//   0          yes                   the level from outside
//   0          no                    PORTx bit: 1 switches the pull-up on; without it the pin is
//                                    open and reads 0 here
//
// Ports are letters 'A' to 'L'; where an index is expected, 0 is port A. Bits are 0 to 7.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#define PORTS_COUNT 12

struct ports_hooks {
    void *board;
    // The program has written PORTx or DDRx of this port (an index); pins change at this cycle.
    void (*written)(void *board, unsigned port, uint64_t cycle);
};

struct ports {
    avr_t *avr;
    const struct ports_hooks *hooks;
    struct {
        uint8_t port, ddr;                 // as last written
        uint8_t driven_mask, driven_level; // from outside
        uint8_t arriving;                  // driven levels that PINx does not show yet
    } pins[PORTS_COUNT];
};

// Follows the part's port registers. Call once, between the part's init and its first reset.
void ports_attach(struct ports *ports, avr_t *avr, const struct ports_hooks *hooks);

// A reset has made all pins inputs; calls `written` for every port. libsimavr does not report this:
// it would keep the program's first write to itself if that write repeats the last one before the
// reset, and would read every pin as low until the pin next changes.
void ports_reset(struct ports *ports);

// The part has this pin.
bool ports_has(const struct ports *ports, char port, unsigned bit);

// The level that the program would read.
bool ports_level(const struct ports *ports, char port, unsigned bit);

// The program has made the pin an output (DDRx).
bool ports_is_output(const struct ports *ports, char port, unsigned bit);

// The pin is an output and high. A pin that the program does not drive counts as low.
bool ports_is_high_output(const struct ports *ports, char port, unsigned bit);

// The pin is already driven to this level from outside.
bool ports_is_driven(const struct ports *ports, char port, unsigned bit, bool level);

// Drives a pin from outside, from this cycle on, not after the present one. The part must have the
// pin. ports_level() has the level at once, PINx a cycle later: its synchronizer.
void ports_drive(
    struct ports *ports, char port, unsigned bit, bool level, uint64_t cycle);
