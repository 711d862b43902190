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

static struct plain_end call(avr_t *avr,
                             const struct plain *plain,
                             unsigned words,
                             unsigned cycles)
{
    if (!push_address(avr, plain->word + words)) {
        return plain_refused();
    }
    return plain_jumped(plain, plain->target, cycles + avr->address_size);
}

struct plain_end plain_ret(avr_t *avr, const struct plain *plain)
{
    uint16_t sp = plain_pair(avr, R_SPL);
    unsigned bytes = avr->address_size;
    uint32_t word = 0;

    if (!plain_is_ram(avr, sp + 1U) || !plain_is_ram(avr, sp + bytes)) {
        return plain_refused();
    }
    for (unsigned i = 1; i <= bytes; i++) {
        word = word << 8 | avr->data[sp + i];
    }
    if (2 * word >= avr->flashend) {
        return plain_refused();
    }
    plain_set_pair(avr, R_SPL, sp + bytes);
    return plain_jumped(plain, 2 * word, 2 + bytes);
}

// ---- jumps ----

struct plain_end plain_rjmp(avr_t *avr, const struct plain *plain)
{
    (void)avr;
    return plain_jumped(plain, plain->target, 2);
}

struct plain_end plain_jmp(avr_t *avr, const struct plain *plain)
{
    (void)avr;
    return plain_jumped(plain, plain->target, 3);
}

struct plain_end plain_ijmp(avr_t *avr, const struct plain *plain)
{
    uint32_t target = 2U * plain_pair(avr, POINTER_Z);

    if (target >= avr->flashend) {
        return plain_refused();
    }
    return plain_jumped(plain, target, 2);
}

struct plain_end plain_rcall(avr_t *avr, const struct plain *plain)
{
    return call(avr, plain, 1, 1);
}

struct plain_end plain_call(avr_t *avr, const struct plain *plain)
{
    return call(avr, plain, 2, 2);
}

struct plain_end plain_icall(avr_t *avr, const struct plain *plain)
{
    uint32_t target = 2U * plain_pair(avr, POINTER_Z);

    if (target >= avr->flashend || !push_address(avr, plain->word + 1U)) {
        return plain_refused();
    }
    return plain_jumped(plain, target, 1U + avr->address_size);
}

// ---- branches and skips ----

static struct plain_end branch(const struct plain *plain, bool taken)
{
    return taken ? plain_jumped(plain, plain->target, 2) : plain_ended(plain, 1, 1);
}

static struct plain_end skip(const struct plain *plain, bool taken)
{
    unsigned words = taken ? plain->words : 0U;

    return plain_ended(plain, 1 + words, 1 + words);
}

struct plain_end plain_brbs(avr_t *avr, const struct plain *plain)
{
    return branch(plain, avr->sreg[plain->d] != 0);
}

struct plain_end plain_brbc(avr_t *avr, const struct plain *plain)
{
    return branch(plain, avr->sreg[plain->d] == 0);
}

struct plain_end plain_cpse(avr_t *avr, const struct plain *plain)
{
    return skip(plain, avr->data[plain->d] == avr->data[plain->r]);
}

struct plain_end plain_sbrs(avr_t *avr, const struct plain *plain)
{
    return skip(plain, (avr->data[plain->d] & plain->constant) != 0);
}

struct plain_end plain_sbrc(avr_t *avr, const struct plain *plain)
{
    return skip(plain, (avr->data[plain->d] & plain->constant) == 0);
}
