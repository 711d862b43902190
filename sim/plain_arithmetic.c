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

static bool end_logic(avr_t *avr, uint8_t d, unsigned result)
{
    avr->data[d] = (uint8_t)result;
    avr->sreg[S_V] = 0;
    set_zns(avr, (uint8_t)result);
    return plain_ended(avr, 1, 1);
}

static bool end_step(avr_t *avr, uint8_t d, uint8_t result, uint8_t overflow_at)
{
    avr->data[d] = result;
    avr->sreg[S_V] = result == overflow_at;
    set_zns(avr, result);
    return plain_ended(avr, 1, 1);
}

static bool end_shift(avr_t *avr, uint8_t d, uint8_t shifted_in)
{
    uint8_t before = avr->data[d];

    avr->data[d] = (uint8_t)(before >> 1 | shifted_in);
    avr->sreg[S_C] = before & 1U;
    avr->sreg[S_V] = shifted_in >> 7 ^ avr->sreg[S_C];
    set_zns(avr, avr->data[d]);
    return plain_ended(avr, 1, 1);
}

static bool end_word(avr_t *avr, uint8_t d, unsigned result)
{
    plain_set_pair(avr, d, result);
    avr->sreg[S_Z] = (uint16_t)result == 0;
    avr->sreg[S_N] = result >> 15 & 1U;
    avr->sreg[S_S] = avr->sreg[S_N] ^ avr->sreg[S_V];
    return plain_ended(avr, 1, 2);
}

static bool end_product(avr_t *avr, int product)
{
    plain_set_pair(avr, 0, (unsigned)product);
    avr->sreg[S_C] = (unsigned)product >> 15 & 1U;
    avr->sreg[S_Z] = product == 0;
    return plain_ended(avr, 1, 2);
}

// ---- copies ----

bool plain_nop(avr_t *avr, const struct plain *plain)
{
    (void)plain;
    return plain_ended(avr, 1, 1);
}

bool plain_mov(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = avr->data[plain->r];
    return plain_ended(avr, 1, 1);
}

bool plain_movw(avr_t *avr, const struct plain *plain)
{
    plain_set_pair(avr, plain->d, plain_pair(avr, plain->r));
    return plain_ended(avr, 1, 1);
}

bool plain_ldi(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = plain->constant;
    return plain_ended(avr, 1, 1);
}

bool plain_swap(avr_t *avr, const struct plain *plain)
{
    uint8_t value = avr->data[plain->d];

    avr->data[plain->d] = (uint8_t)(value << 4 | value >> 4);
    return plain_ended(avr, 1, 1);
}

// ---- sums ----

bool plain_add(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = add(avr, avr->data[plain->d], avr->data[plain->r], 0);
    return plain_ended(avr, 1, 1);
}

bool plain_adc(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] =
        add(avr, avr->data[plain->d], avr->data[plain->r], avr->sreg[S_C]);
    return plain_ended(avr, 1, 1);
}

bool plain_adiw(avr_t *avr, const struct plain *plain)
{
    unsigned before = plain_pair(avr, plain->d);
    unsigned sum = before + plain->constant;

    avr->sreg[S_C] = sum >> 16 & 1U;
    avr->sreg[S_V] = (~before & sum) >> 15 & 1U;
    return end_word(avr, plain->d, sum);
}

bool plain_inc(avr_t *avr, const struct plain *plain)
{
    return end_step(avr, plain->d, (uint8_t)(avr->data[plain->d] + 1U), 0x80);
}

bool plain_sub(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = subtract(avr, avr->data[plain->d], avr->data[plain->r], 0);
    return plain_ended(avr, 1, 1);
}

bool plain_sbc(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = subtract_higher(avr, avr->data[plain->d], avr->data[plain->r]);
    return plain_ended(avr, 1, 1);
}

bool plain_subi(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = subtract(avr, avr->data[plain->d], plain->constant, 0);
    return plain_ended(avr, 1, 1);
}

bool plain_sbci(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = subtract_higher(avr, avr->data[plain->d], plain->constant);
    return plain_ended(avr, 1, 1);
}

bool plain_sbiw(avr_t *avr, const struct plain *plain)
{
    unsigned before = plain_pair(avr, plain->d);
    unsigned difference = before - plain->constant;

    avr->sreg[S_C] = difference >> 16 & 1U;
    avr->sreg[S_V] = (before & ~difference) >> 15 & 1U;
    return end_word(avr, plain->d, difference);
}

bool plain_dec(avr_t *avr, const struct plain *plain)
{
    return end_step(avr, plain->d, (uint8_t)(avr->data[plain->d] - 1U), 0x7F);
}

bool plain_neg(avr_t *avr, const struct plain *plain)
{
    avr->data[plain->d] = subtract(avr, 0, avr->data[plain->d], 0);
    return plain_ended(avr, 1, 1);
}

bool plain_cp(avr_t *avr, const struct plain *plain)
{
    (void)subtract(avr, avr->data[plain->d], avr->data[plain->r], 0);
    return plain_ended(avr, 1, 1);
}

bool plain_cpc(avr_t *avr, const struct plain *plain)
{
    (void)subtract_higher(avr, avr->data[plain->d], avr->data[plain->r]);
    return plain_ended(avr, 1, 1);
}

bool plain_cpi(avr_t *avr, const struct plain *plain)
{
    (void)subtract(avr, avr->data[plain->d], plain->constant, 0);
    return plain_ended(avr, 1, 1);
}

// ---- logic ----

bool plain_and(avr_t *avr, const struct plain *plain)
{
    return end_logic(avr, plain->d, avr->data[plain->d] & avr->data[plain->r]);
}

bool plain_or(avr_t *avr, const struct plain *plain)
{
    return end_logic(avr, plain->d, avr->data[plain->d] | avr->data[plain->r]);
}

bool plain_eor(avr_t *avr, const struct plain *plain)
{
    return end_logic(avr, plain->d, avr->data[plain->d] ^ avr->data[plain->r]);
}

bool plain_andi(avr_t *avr, const struct plain *plain)
{
    return end_logic(avr, plain->d, avr->data[plain->d] & plain->constant);
}

bool plain_ori(avr_t *avr, const struct plain *plain)
{
    return end_logic(avr, plain->d, avr->data[plain->d] | plain->constant);
}

bool plain_com(avr_t *avr, const struct plain *plain)
{
    avr->sreg[S_C] = 1;
    return end_logic(avr, plain->d, avr->data[plain->d] ^ 0xFFU);
}

// ---- shifts ----

bool plain_asr(avr_t *avr, const struct plain *plain)
{
    return end_shift(avr, plain->d, avr->data[plain->d] & 0x80U);
}

bool plain_lsr(avr_t *avr, const struct plain *plain)
{
    return end_shift(avr, plain->d, 0);
}

bool plain_ror(avr_t *avr, const struct plain *plain)
{
    return end_shift(avr, plain->d, (uint8_t)(avr->sreg[S_C] << 7));
}

// ---- products ----

bool plain_mul(avr_t *avr, const struct plain *plain)
{
    return end_product(avr, avr->data[plain->d] * avr->data[plain->r]);
}

bool plain_muls(avr_t *avr, const struct plain *plain)
{
    return end_product(avr, (int8_t)avr->data[plain->d] * (int8_t)avr->data[plain->r]);
}

bool plain_mulsu(avr_t *avr, const struct plain *plain)
{
    return end_product(avr, (int8_t)avr->data[plain->d] * avr->data[plain->r]);
}

// ---- bits ----

bool plain_bst(avr_t *avr, const struct plain *plain)
{
    avr->sreg[S_T] = (avr->data[plain->d] & plain->constant) != 0;
    return plain_ended(avr, 1, 1);
}

bool plain_bld(avr_t *avr, const struct plain *plain)
{
    unsigned others = avr->data[plain->d] & ~(unsigned)plain->constant;

    avr->data[plain->d] =
        (uint8_t)(others | (avr->sreg[S_T] != 0 ? plain->constant : 0U));
    return plain_ended(avr, 1, 1);
}

bool plain_bset(avr_t *avr, const struct plain *plain)
{
    avr->sreg[plain->d] = 1;
    return plain_ended(avr, 1, 1);
}

bool plain_bclr(avr_t *avr, const struct plain *plain)
{
    avr->sreg[plain->d] = 0;
    return plain_ended(avr, 1, 1);
}
