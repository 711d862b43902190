// SPDX-License-Identifier: MIT
//
// What simavr's skip instructions (SBRS, SBRC, SBIS, SBIC, CPSE) get wrong: they take ADIW and SBIW
// with a constant of which K mod 16 is 12 or more for JMP or CALL, because those opcodes pass
// simavr's mask for two words, and skip the word behind them too. The places where such a pair
// stands in an image are found when it is loaded; there the run loop puts the skip right.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <sim_avr.h>

struct skips {
    bool *wrong; // by flash word; NULL where the image has no such place
};

// False when there is no memory for it.
bool skips_find(struct skips *skips, const avr_t *avr);

void skips_free(struct skips *skips);

// Behind avr_run_one(): the program counter that it should have given. avr->pc is the
// instruction's still.
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
