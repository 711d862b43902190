// SPDX-License-Identifier: MIT
//
// Plain instructions: those that touch only registers, flags, RAM and flash. They are most of what
// a program executes, nothing outside the core can notice them, and simavr decodes each of them
// anew. Here they are decoded once, when the image is loaded, and executed several times faster.
//
// Everything else stays simavr's: I/O registers, the I bit, SLEEP, WDR, RETI, and every access or
// jump to an address that the part does not have. SPM too, but what it writes is not decoded: no
// image here writes its own flash.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#include "plain_instruction.h"

struct plain_program {
    struct plain *at; // by flash word
};

// Decodes the flash. False if there is no memory for it.
bool plain_decode(struct plain_program *program, const avr_t *avr);

// Decodes the word at this flash address (bytes) once more, and the one before it, which may skip
// it: the word has been patched.
void plain_patched(struct plain_program *program, const avr_t *avr, uint32_t address);

// Forgets the program.
void plain_free(struct plain_program *program);

// Executes plain instructions, at least one, until the part has reached this cycle (it may pass it
// by the rest of an instruction). False if an instruction for simavr comes first.
static inline bool plain_run(const struct plain_program *program,
                             avr_t *avr,
                             uint64_t cycle)
{
    const struct plain *plain = &program->at[avr->pc / 2];
    uint64_t now = plain->execute(avr, plain, avr->cycle, cycle);

    avr->cycle = now & ~PLAIN_REFUSED;
    return (now & PLAIN_REFUSED) == 0;
}
