// SPDX-License-Identifier: MIT

#include "plain_arithmetic.h"

// ---- flags ----

// Z, N and S of a result; V is set already.
static void set_zns(avr_t *avr, uint8_t result)
{
    avr->sreg[S_Z] = result == 0;
    avr->sreg[S_N] = result >> 7;
    avr->sreg[S_S] = avr->sreg[S_N] ^ avr->sreg[S_V];
}

static uint8_t add(avr_t *avr, unsigned a, unsigned b, unsigned carry)
{
    unsigned sum = a + b + carry;

    avr->sreg[S_C] = sum >> 8 & 1U;
    avr->sreg[S_H] = (a ^ b ^ sum) >> 4 & 1U;
    avr->sreg[S_V] = (~(a ^ b) & (a ^ sum)) >> 7 & 1U;
    set_zns(avr, (uint8_t)sum);
    return (uint8_t)sum;
}

static uint8_t subtract(avr_t *avr, unsigned a, unsigned b, unsigned carry)
{
    unsigned difference = a - b - carry;

    avr->sreg[S_C] = difference >> 8 & 1U;
    avr->sreg[S_H] = (a ^ b ^ difference) >> 4 & 1U;
    avr->sreg[S_V] = ((a ^ b) & (a ^ difference)) >> 7 & 1U;
    set_zns(avr, (uint8_t)difference);
    return (uint8_t)difference;
}

// Z stays clear if a lower byte was not zero.
static uint8_t subtract_higher(avr_t *avr, unsigned a, unsigned b)
{
    uint8_t zero_so_far = avr->sreg[S_Z];
    uint8_t difference = subtract(avr, a, b, avr->sreg[S_C]);

    avr->sreg[S_Z] &= zero_so_far;
    return difference;
}

static struct plain_end end_logic(avr_t *avr, const struct plain *plain, unsigned result)
{
    avr->data[plain->d] = (uint8_t)result;
    avr->sreg[S_V] = 0;
    set_zns(avr, (uint8_t)result);
    return plain_ended(plain, 1, 1);
}

static struct plain_end end_step(avr_t *avr, const struct plain *plain, uint8_t result, uint8_t overflow_at)
{
    avr->data[plain->d] = result;
    avr->sreg[S_V] = result == overflow_at;
    set_zns(avr, result);
    return plain_ended(plain, 1, 1);
}

static struct plain_end end_shift(avr_t *avr, const struct plain *plain, uint8_t shifted_in)
{
    uint8_t before = avr->data[plain->d];

    avr->data[plain->d] = (uint8_t)(before >> 1 | shifted_in);
    avr->sreg[S_C] = before & 1U;
    avr->sreg[S_V] = shifted_in >> 7 ^ avr->sreg[S_C];
    set_zns(avr, avr->data[plain->d]);
    return plain_ended(plain, 1, 1);
}

static struct plain_end end_word(avr_t *avr, const struct plain *plain, unsigned result)
{
    plain_set_pair(avr, plain->d, result);
    avr->sreg[S_Z] = (uint16_t)result == 0;
    avr->sreg[S_N] = result >> 15 & 1U;
    avr->sreg[S_S] = avr->sreg[S_N] ^ avr->sreg[S_V];
    return plain_ended(plain, 1, 2);
}

static struct plain_end end_product(avr_t *avr, const struct plain *plain, int product)
{
    plain_set_pair(avr, 0, (unsigned)product);
    avr->sreg[S_C] = (unsigned)product >> 15 & 1U;
    avr->sreg[S_Z] = product == 0;
    return plain_ended(plain, 1, 2);
}

// ---- copies ----

struct plain_end plain_nop(avr_t *avr, const struct plain *plain)
{
    (void)avr;
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_mov(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = avr->data[plain->r];
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_movw(avr_t *avr, const struct plain *plain)
{
    plain_set_pair(avr, plain->d, plain_pair(avr, plain->r));
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_ldi(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = plain->constant;
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_swap(avr_t *avr, const struct plain *plain)
{
    uint8_t value = avr->data[plain->d];

    avr->data[plain->d] = (uint8_t)(value << 4 | value >> 4);
    return plain_ended(plain, 1, 1);
}

// ---- sums ----

struct plain_end plain_add(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = add(avr, avr->data[plain->d], avr->data[plain->r], 0);
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_adc(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] =
        add(avr, avr->data[plain->d], avr->data[plain->r], avr->sreg[S_C]);
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_adiw(avr_t *avr, const struct plain *plain)
{
    unsigned before = plain_pair(avr, plain->d);
    unsigned sum = before + plain->constant;

    avr->sreg[S_C] = sum >> 16 & 1U;
    avr->sreg[S_V] = (~before & sum) >> 15 & 1U;
    return end_word(avr, plain, sum);
}

struct plain_end plain_inc(avr_t *avr, const struct plain *plain)
{
    return end_step(avr, plain, (uint8_t)(avr->data[plain->d] + 1U), 0x80);
}

struct plain_end plain_sub(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = subtract(avr, avr->data[plain->d], avr->data[plain->r], 0);
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_sbc(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = subtract_higher(avr, avr->data[plain->d], avr->data[plain->r]);
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_subi(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = subtract(avr, avr->data[plain->d], plain->constant, 0);
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_sbci(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = subtract_higher(avr, avr->data[plain->d], plain->constant);
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_sbiw(avr_t *avr, const struct plain *plain)
{
    unsigned before = plain_pair(avr, plain->d);
    unsigned difference = before - plain->constant;

    avr->sreg[S_C] = difference >> 16 & 1U;
    avr->sreg[S_V] = (before & ~difference) >> 15 & 1U;
    return end_word(avr, plain, difference);
}

struct plain_end plain_dec(avr_t *avr, const struct plain *plain)
{
    return end_step(avr, plain, (uint8_t)(avr->data[plain->d] - 1U), 0x7F);
}

struct plain_end plain_neg(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = subtract(avr, 0, avr->data[plain->d], 0);
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_cp(avr_t *avr, const struct plain *plain)
{
    (void)subtract(avr, avr->data[plain->d], avr->data[plain->r], 0);
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_cpc(avr_t *avr, const struct plain *plain)
{
    (void)subtract_higher(avr, avr->data[plain->d], avr->data[plain->r]);
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_cpi(avr_t *avr, const struct plain *plain)
{
    (void)subtract(avr, avr->data[plain->d], plain->constant, 0);
    return plain_ended(plain, 1, 1);
}

// ---- logic ----

struct plain_end plain_and(avr_t *avr, const struct plain *plain)
{
    return end_logic(avr, plain, avr->data[plain->d] & avr->data[plain->r]);
}

struct plain_end plain_or(avr_t *avr, const struct plain *plain)
{
    return end_logic(avr, plain, avr->data[plain->d] | avr->data[plain->r]);
}

struct plain_end plain_eor(avr_t *avr, const struct plain *plain)
{
    return end_logic(avr, plain, avr->data[plain->d] ^ avr->data[plain->r]);
}

struct plain_end plain_andi(avr_t *avr, const struct plain *plain)
{
    return end_logic(avr, plain, avr->data[plain->d] & plain->constant);
}

struct plain_end plain_ori(avr_t *avr, const struct plain *plain)
{
    return end_logic(avr, plain, avr->data[plain->d] | plain->constant);
}

struct plain_end plain_com(avr_t *avr, const struct plain *plain)
{
    avr->sreg[S_C] = 1;
    return end_logic(avr, plain, avr->data[plain->d] ^ 0xFFU);
}

// ---- shifts ----

struct plain_end plain_asr(avr_t *avr, const struct plain *plain)
{
    return end_shift(avr, plain, avr->data[plain->d] & 0x80U);
}

struct plain_end plain_lsr(avr_t *avr, const struct plain *plain)
{
    return end_shift(avr, plain, 0);
}

struct plain_end plain_ror(avr_t *avr, const struct plain *plain)
{
    return end_shift(avr, plain, (uint8_t)(avr->sreg[S_C] << 7));
}

// ---- products ----

struct plain_end plain_mul(avr_t *avr, const struct plain *plain)
{
    return end_product(avr, plain, avr->data[plain->d] * avr->data[plain->r]);
}

struct plain_end plain_muls(avr_t *avr, const struct plain *plain)
{
    return end_product(avr, plain, (int8_t)avr->data[plain->d] * (int8_t)avr->data[plain->r]);
}

struct plain_end plain_mulsu(avr_t *avr, const struct plain *plain)
{
    return end_product(avr, plain, (int8_t)avr->data[plain->d] * avr->data[plain->r]);
}

// ---- bits ----

struct plain_end plain_bst(avr_t *avr, const struct plain *plain)
{
    avr->sreg[S_T] = (avr->data[plain->d] & plain->constant) != 0;
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_bld(avr_t *avr, const struct plain *plain)
{
    unsigned others = avr->data[plain->d] & ~(unsigned)plain->constant;

    avr->data[plain->d] =
        (uint8_t)(others | (avr->sreg[S_T] != 0 ? plain->constant : 0U));
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_bset(avr_t *avr, const struct plain *plain)
{
    avr->sreg[plain->d] = 1;
    return plain_ended(plain, 1, 1);
}

struct plain_end plain_bclr(avr_t *avr, const struct plain *plain)
{
    avr->sreg[plain->d] = 0;
    return plain_ended(plain, 1, 1);
}
