// SPDX-License-Identifier: MIT

#include "plain_flow.h"

#define POINTER_Z 30U

// ---- the stack of return addresses ----

// The return address goes below the stack pointer, its low byte first.
static bool push_address(avr_t *avr, uint32_t back)
{
    uint16_t sp = plain_pair(avr, R_SPL);
    unsigned bytes = avr->address_size;

    if (!plain_is_ram(avr, sp) || !plain_is_ram(avr, sp - bytes + 1U)) {
        return false;
    }
    for (unsigned i = 0; i < bytes; i++) {
        avr->data[sp - i] = (uint8_t)(back >> 8 * i);
    }
    plain_set_pair(avr, R_SPL, sp - bytes);
    return true;
}

static uint64_t call(PLAIN_ARGUMENTS, unsigned words, unsigned cycles)
{
    if (!push_address(avr, plain->word + words)) {
        return plain_refused(PLAIN_PASSED);
    }
    return plain_jumped(PLAIN_PASSED, plain->target, cycles + avr->address_size);
}

uint64_t plain_ret(PLAIN_ARGUMENTS)
{
    uint16_t sp = plain_pair(avr, R_SPL);
    unsigned bytes = avr->address_size;
    uint32_t word = 0;

    if (!plain_is_ram(avr, sp + 1U) || !plain_is_ram(avr, sp + bytes)) {
        return plain_refused(PLAIN_PASSED);
    }
    for (unsigned i = 1; i <= bytes; i++) {
        word = word << 8 | avr->data[sp + i];
    }
    if (2 * word >= avr->flashend) {
        return plain_refused(PLAIN_PASSED);
    }
    plain_set_pair(avr, R_SPL, sp + bytes);
    return plain_jumped(PLAIN_PASSED, 2 * word, 2 + bytes);
}

// ---- jumps ----

uint64_t plain_rjmp(PLAIN_ARGUMENTS)
{
    return plain_jumped(PLAIN_PASSED, plain->target, 2);
}

uint64_t plain_jmp(PLAIN_ARGUMENTS)
{
    return plain_jumped(PLAIN_PASSED, plain->target, 3);
}

uint64_t plain_ijmp(PLAIN_ARGUMENTS)
{
    uint32_t target = 2U * plain_pair(avr, POINTER_Z);

    if (target >= avr->flashend) {
        return plain_refused(PLAIN_PASSED);
    }
    return plain_jumped(PLAIN_PASSED, target, 2);
}

uint64_t plain_rcall(PLAIN_ARGUMENTS)
{
    return call(PLAIN_PASSED, 1, 1);
}

uint64_t plain_call(PLAIN_ARGUMENTS)
{
    return call(PLAIN_PASSED, 2, 2);
}

uint64_t plain_icall(PLAIN_ARGUMENTS)
{
    uint32_t target = 2U * plain_pair(avr, POINTER_Z);

    if (target >= avr->flashend || !push_address(avr, plain->word + 1U)) {
        return plain_refused(PLAIN_PASSED);
    }
    return plain_jumped(PLAIN_PASSED, target, 1U + avr->address_size);
}

// ---- branches and skips ----

static uint64_t branch(PLAIN_ARGUMENTS, bool taken)
{
    return taken ? plain_jumped(PLAIN_PASSED, plain->target, 2)
                 : plain_ended(PLAIN_PASSED, 1, 1);
}

static uint64_t skip(PLAIN_ARGUMENTS, bool taken)
{
    unsigned words = taken ? plain->words : 0U;

    return plain_ended(PLAIN_PASSED, 1 + words, 1 + words);
}

uint64_t plain_brbs(PLAIN_ARGUMENTS)
{
    return branch(PLAIN_PASSED, avr->sreg[plain->d] != 0);
}

uint64_t plain_brbc(PLAIN_ARGUMENTS)
{
    return branch(PLAIN_PASSED, avr->sreg[plain->d] == 0);
}

uint64_t plain_cpse(PLAIN_ARGUMENTS)
{
    return skip(PLAIN_PASSED, avr->data[plain->d] == avr->data[plain->r]);
}

uint64_t plain_sbrs(PLAIN_ARGUMENTS)
{
    return skip(PLAIN_PASSED, (avr->data[plain->d] & plain->constant) != 0);
}

uint64_t plain_sbrc(PLAIN_ARGUMENTS)
{
    return skip(PLAIN_PASSED, (avr->data[plain->d] & plain->constant) == 0);
}
