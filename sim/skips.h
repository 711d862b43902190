// SPDX-License-Identifier: MIT
//
// Corrects simavr's skip instructions (SBRS, SBRC, SBIS, SBIC, CPSE). They take ADIW and SBIW with
// a constant K of which K mod 16 is 12 or more for a JMP or CALL, because those opcodes match
// simavr's mask for instructions of two words, and then skip the following word too. Loading an
// image finds the places of such pairs; the run loop corrects the skip there.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <sim_avr.h>

struct skips {
    bool *wrong; // by flash word; NULL where the image has no such place
};

// Finds the places in the flash. False if there is no memory for them.
bool skips_find(struct skips *skips, const avr_t *avr);

// Forgets the places.
void skips_free(struct skips *skips);

// Call with the result of avr_run_one(), while avr->pc is still that of the instruction: returns
// the program counter that avr_run_one() should have returned, and corrects avr->cycle.
static inline avr_flashaddr_t skips_mend(const struct skips *skips,
                                         avr_t *avr,
                                         avr_flashaddr_t next_pc)
{
    if (skips->wrong != NULL && skips->wrong[avr->pc / 2] && next_pc == avr->pc + 6) {
        avr->cycle--; // one word skipped: 2 cycles, not 3
        return next_pc - 2;
    }
    return next_pc;
}
