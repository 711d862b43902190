// SPDX-License-Identifier: MIT

#include "plain_flow.h"

#define POINTER_Z 30U

// ---- the stack of return addresses ----

// The return address goes below the stack pointer, its low byte first.
static bool call(avr_t *avr, uint32_t target, unsigned words, unsigned cycles)
{
    uint32_t back = avr->pc / 2 + words;
    uint16_t sp = plain_pair(avr, R_SPL);
    unsigned bytes = avr->address_size;

    if (!plain_is_ram(avr, sp) || !plain_is_ram(avr, sp - bytes + 1U) ||
        target >= avr->flashend) {
        return false;
    }
    for (unsigned i = 0; i < bytes; i++) {
        avr->data[sp - i] = (uint8_t)(back >> 8 * i);
    }
    plain_set_pair(avr, R_SPL, sp - bytes);
    return plain_jumped(avr, target, cycles + bytes);
}

bool plain_ret(avr_t *avr, const struct plain *plain)
{
    uint16_t sp = plain_pair(avr, R_SPL);
    unsigned bytes = avr->address_size;
    uint32_t word = 0;

    (void)plain;
    if (!plain_is_ram(avr, sp + 1U) || !plain_is_ram(avr, sp + bytes)) {
        return false;
    }
    for (unsigned i = 1; i <= bytes; i++) {
        word = word << 8 | avr->data[sp + i];
    }
    if (2 * word >= avr->flashend) {
        return false;
    }
    plain_set_pair(avr, R_SPL, sp + bytes);
    return plain_jumped(avr, 2 * word, 2 + bytes);
}

// ---- jumps ----

bool plain_rjmp(avr_t *avr, const struct plain *plain)
{
    return plain_jumped(avr, plain->target, 2);
}

bool plain_jmp(avr_t *avr, const struct plain *plain)
{
    return plain_jumped(avr, plain->target, 3);
}

bool plain_ijmp(avr_t *avr, const struct plain *plain)
{
    uint32_t target = 2U * plain_pair(avr, POINTER_Z);

    (void)plain;
    return target < avr->flashend && plain_jumped(avr, target, 2);
}

bool plain_rcall(avr_t *avr, const struct plain *plain)
{
    return call(avr, plain->target, 1, 1);
}

bool plain_call(avr_t *avr, const struct plain *plain)
{
    return call(avr, plain->target, 2, 2);
}

bool plain_icall(avr_t *avr, const struct plain *plain)
{
    (void)plain;
    return call(avr, 2U * plain_pair(avr, POINTER_Z), 1, 1);
}

// ---- branches and skips ----

static bool branch(avr_t *avr, const struct plain *plain, bool taken)
{
    return taken ? plain_jumped(avr, plain->target, 2) : plain_ended(avr, 1, 1);
}

static bool skip(avr_t *avr, const struct plain *plain, bool taken)
{
    unsigned words = taken ? plain->words : 0U;

    return plain_ended(avr, 1 + words, 1 + words);
}

bool plain_brbs(avr_t *avr, const struct plain *plain)
{
    return branch(avr, plain, avr->sreg[plain->d] != 0);
}

bool plain_brbc(avr_t *avr, const struct plain *plain)
{
    return branch(avr, plain, avr->sreg[plain->d] == 0);
}

bool plain_cpse(avr_t *avr, const struct plain *plain)
{
    return skip(avr, plain, avr->data[plain->d] == avr->data[plain->r]);
}

bool plain_sbrs(avr_t *avr, const struct plain *plain)
{
    return skip(avr, plain, (avr->data[plain->d] & plain->constant) != 0);
}

bool plain_sbrc(avr_t *avr, const struct plain *plain)
{
    return skip(avr, plain, (avr->data[plain->d] & plain->constant) == 0);
}
