// SPDX-License-Identifier: MIT

#include "plain_memory.h"

#define POINTER_Z 30U

// ---- loads ----

// `pointer` is what the pointer register holds afterwards. It is set first: a load into one of its
// own halves wins.
static struct plain_end load(avr_t *avr,
                 const struct plain *plain,
                 uint16_t address,
                 unsigned pointer)
{
    if (!plain_is_ram(avr, address)) {
        return plain_refused();
    }
    plain_set_pair(avr, plain->r, pointer);
    avr->data[plain->d] = avr->data[address];
    return plain_ended(plain, 1, 2);
}

struct plain_end plain_lds(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = avr->data[plain->target];
    return plain_ended(plain, 2, 2);
}

struct plain_end plain_ldd(avr_t *avr, const struct plain *plain)
{
    uint16_t pointer = plain_pair(avr, plain->r);

    return load(avr, plain, (uint16_t)(pointer + plain->constant), pointer);
}

struct plain_end plain_ld_up(avr_t *avr, const struct plain *plain)
{
    uint16_t pointer = plain_pair(avr, plain->r);

    return load(avr, plain, pointer, pointer + 1U);
}

struct plain_end plain_ld_down(avr_t *avr, const struct plain *plain)
{
    uint16_t pointer = (uint16_t)(plain_pair(avr, plain->r) - 1U);

    return load(avr, plain, pointer, pointer);
}

struct plain_end plain_pop(avr_t *avr, const struct plain *plain)
{
    uint32_t top = plain_pair(avr, R_SPL) + 1U;

    if (!plain_is_ram(avr, top)) {
        return plain_refused();
    }
    plain_set_pair(avr, R_SPL, top);
    avr->data[plain->d] = avr->data[top];
    return plain_ended(plain, 1, 2);
}

// ---- stores ----

static struct plain_end store(avr_t *avr,
                  const struct plain *plain,
                  uint16_t address,
                  unsigned pointer)
{
    if (!plain_is_ram(avr, address)) {
        return plain_refused();
    }
    avr->data[address] = avr->data[plain->d];
    plain_set_pair(avr, plain->r, pointer);
    return plain_ended(plain, 1, 2);
}

struct plain_end plain_sts(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->target] = avr->data[plain->d];
    return plain_ended(plain, 2, 2);
}

struct plain_end plain_std(avr_t *avr, const struct plain *plain)
{
    uint16_t pointer = plain_pair(avr, plain->r);

    return store(avr, plain, (uint16_t)(pointer + plain->constant), pointer);
}

struct plain_end plain_st_up(avr_t *avr, const struct plain *plain)
{
    uint16_t pointer = plain_pair(avr, plain->r);

    return store(avr, plain, pointer, pointer + 1U);
}

struct plain_end plain_st_down(avr_t *avr, const struct plain *plain)
{
    uint16_t pointer = (uint16_t)(plain_pair(avr, plain->r) - 1U);

    return store(avr, plain, pointer, pointer);
}

struct plain_end plain_push(avr_t *avr, const struct plain *plain)
{
    uint16_t sp = plain_pair(avr, R_SPL);

    if (!plain_is_ram(avr, sp)) {
        return plain_refused();
    }
    avr->data[sp] = avr->data[plain->d];
    plain_set_pair(avr, R_SPL, sp - 1U);
    return plain_ended(plain, 1, 2);
}

// ---- flash ----

static struct plain_end load_flash(avr_t *avr, const struct plain *plain, unsigned step)
{
    uint16_t pointer = plain_pair(avr, POINTER_Z);

    if (pointer > avr->flashend) {
        return plain_refused();
    }
    avr->data[plain->d] = avr->flash[pointer];
    if (step != 0) {
        plain_set_pair(avr, POINTER_Z, pointer + step);
    }
    return plain_ended(plain, 1, 3);
}

struct plain_end plain_lpm(avr_t *avr, const struct plain *plain)
{
    return load_flash(avr, plain, 0);
}

struct plain_end plain_lpm_up(avr_t *avr, const struct plain *plain)
{
    return load_flash(avr, plain, 1);
}
