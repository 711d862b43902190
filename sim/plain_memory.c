// SPDX-License-Identifier: MIT

#include "plain_memory.h"

#define POINTER_Z 30U

// ---- loads ----

// `pointer` is what the pointer register holds afterwards. It is set first: a load into one of its
// own halves wins.
static uint64_t load(PLAIN_ARGUMENTS, uint16_t address, unsigned pointer)
{
    if (!plain_is_ram(avr, address)) {
        return plain_refused(PLAIN_PASSED);
    }
    plain_set_pair(avr, plain->r, pointer);
    avr->data[plain->d] = avr->data[address];
    return plain_ended(PLAIN_PASSED, 1, 2);
}

uint64_t plain_lds(PLAIN_ARGUMENTS)
{
    avr->data[plain->d] = avr->data[plain->target];
    return plain_ended(PLAIN_PASSED, 2, 2);
}

uint64_t plain_ldd(PLAIN_ARGUMENTS)
{
    uint16_t pointer = plain_pair(avr, plain->r);

    return load(PLAIN_PASSED, (uint16_t)(pointer + plain->constant), pointer);
}

uint64_t plain_ld_up(PLAIN_ARGUMENTS)
{
    uint16_t pointer = plain_pair(avr, plain->r);

    return load(PLAIN_PASSED, pointer, pointer + 1U);
}

uint64_t plain_ld_down(PLAIN_ARGUMENTS)
{
    uint16_t pointer = (uint16_t)(plain_pair(avr, plain->r) - 1U);

    return load(PLAIN_PASSED, pointer, pointer);
}

uint64_t plain_pop(PLAIN_ARGUMENTS)
{
    uint32_t top = plain_pair(avr, R_SPL) + 1U;

    if (!plain_is_ram(avr, top)) {
        return plain_refused(PLAIN_PASSED);
    }
    plain_set_pair(avr, R_SPL, top);
    avr->data[plain->d] = avr->data[top];
    return plain_ended(PLAIN_PASSED, 1, 2);
}

// ---- stores ----

static uint64_t store(PLAIN_ARGUMENTS, uint16_t address, unsigned pointer)
{
    if (!plain_is_ram(avr, address)) {
        return plain_refused(PLAIN_PASSED);
    }
    avr->data[address] = avr->data[plain->d];
    plain_set_pair(avr, plain->r, pointer);
    return plain_ended(PLAIN_PASSED, 1, 2);
}

uint64_t plain_sts(PLAIN_ARGUMENTS)
{
    avr->data[plain->target] = avr->data[plain->d];
    return plain_ended(PLAIN_PASSED, 2, 2);
}

uint64_t plain_std(PLAIN_ARGUMENTS)
{
    uint16_t pointer = plain_pair(avr, plain->r);

    return store(PLAIN_PASSED, (uint16_t)(pointer + plain->constant), pointer);
}

uint64_t plain_st_up(PLAIN_ARGUMENTS)
{
    uint16_t pointer = plain_pair(avr, plain->r);

    return store(PLAIN_PASSED, pointer, pointer + 1U);
}

uint64_t plain_st_down(PLAIN_ARGUMENTS)
{
    uint16_t pointer = (uint16_t)(plain_pair(avr, plain->r) - 1U);

    return store(PLAIN_PASSED, pointer, pointer);
}

uint64_t plain_push(PLAIN_ARGUMENTS)
{
    uint16_t sp = plain_pair(avr, R_SPL);

    if (!plain_is_ram(avr, sp)) {
        return plain_refused(PLAIN_PASSED);
    }
    avr->data[sp] = avr->data[plain->d];
    plain_set_pair(avr, R_SPL, sp - 1U);
    return plain_ended(PLAIN_PASSED, 1, 2);
}

// ---- flash ----

static uint64_t load_flash(PLAIN_ARGUMENTS, unsigned step)
{
    uint16_t pointer = plain_pair(avr, POINTER_Z);

    if (pointer > avr->flashend) {
        return plain_refused(PLAIN_PASSED);
    }
    avr->data[plain->d] = avr->flash[pointer];
    if (step != 0) {
        plain_set_pair(avr, POINTER_Z, pointer + step);
    }
    return plain_ended(PLAIN_PASSED, 1, 3);
}

uint64_t plain_lpm(PLAIN_ARGUMENTS)
{
    return load_flash(PLAIN_PASSED, 0);
}

uint64_t plain_lpm_up(PLAIN_ARGUMENTS)
{
    return load_flash(PLAIN_PASSED, 1);
}
