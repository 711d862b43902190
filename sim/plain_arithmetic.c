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

static uint64_t end_logic(PLAIN_ARGUMENTS, unsigned result)
{
    avr->data[plain->d] = (uint8_t)result;
    avr->sreg[S_V] = 0;
    set_zns(avr, (uint8_t)result);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

static uint64_t end_step(PLAIN_ARGUMENTS, uint8_t result, uint8_t overflow_at)
{
    avr->data[plain->d] = result;
    avr->sreg[S_V] = result == overflow_at;
    set_zns(avr, result);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

static uint64_t end_shift(PLAIN_ARGUMENTS, uint8_t shifted_in)
{
    uint8_t before = avr->data[plain->d];

    avr->data[plain->d] = (uint8_t)(before >> 1 | shifted_in);
    avr->sreg[S_C] = before & 1U;
    avr->sreg[S_V] = shifted_in >> 7 ^ avr->sreg[S_C];
    set_zns(avr, avr->data[plain->d]);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

static uint64_t end_word(PLAIN_ARGUMENTS, unsigned result)
{
    plain_set_pair(avr, plain->d, result);
    avr->sreg[S_Z] = (uint16_t)result == 0;
    avr->sreg[S_N] = result >> 15 & 1U;
    avr->sreg[S_S] = avr->sreg[S_N] ^ avr->sreg[S_V];
    return plain_ended(PLAIN_PASSED, 1, 2);
}

static uint64_t end_product(PLAIN_ARGUMENTS, int product)
{
    plain_set_pair(avr, 0, (unsigned)product);
    avr->sreg[S_C] = (unsigned)product >> 15 & 1U;
    avr->sreg[S_Z] = product == 0;
    return plain_ended(PLAIN_PASSED, 1, 2);
}

// ---- copies ----

uint64_t plain_nop(PLAIN_ARGUMENTS)
{
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_mov(PLAIN_ARGUMENTS)
{
    avr->data[plain->d] = avr->data[plain->r];
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_movw(PLAIN_ARGUMENTS)
{
    plain_set_pair(avr, plain->d, plain_pair(avr, plain->r));
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_ldi(PLAIN_ARGUMENTS)
{
    avr->data[plain->d] = plain->constant;
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_swap(PLAIN_ARGUMENTS)
{
    uint8_t value = avr->data[plain->d];

    avr->data[plain->d] = (uint8_t)(value << 4 | value >> 4);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

// ---- sums ----

uint64_t plain_add(PLAIN_ARGUMENTS)
{
    avr->data[plain->d] = add(avr, avr->data[plain->d], avr->data[plain->r], 0);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_adc(PLAIN_ARGUMENTS)
{
    avr->data[plain->d] =
        add(avr, avr->data[plain->d], avr->data[plain->r], avr->sreg[S_C]);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_adiw(PLAIN_ARGUMENTS)
{
    unsigned before = plain_pair(avr, plain->d);
    unsigned sum = before + plain->constant;

    avr->sreg[S_C] = sum >> 16 & 1U;
    avr->sreg[S_V] = (~before & sum) >> 15 & 1U;
    return end_word(PLAIN_PASSED, sum);
}

uint64_t plain_inc(PLAIN_ARGUMENTS)
{
    return end_step(PLAIN_PASSED, (uint8_t)(avr->data[plain->d] + 1U), 0x80);
}

uint64_t plain_sub(PLAIN_ARGUMENTS)
{
    avr->data[plain->d] = subtract(avr, avr->data[plain->d], avr->data[plain->r], 0);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_sbc(PLAIN_ARGUMENTS)
{
    avr->data[plain->d] = subtract_higher(avr, avr->data[plain->d], avr->data[plain->r]);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_subi(PLAIN_ARGUMENTS)
{
    avr->data[plain->d] = subtract(avr, avr->data[plain->d], plain->constant, 0);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_sbci(PLAIN_ARGUMENTS)
{
    avr->data[plain->d] = subtract_higher(avr, avr->data[plain->d], plain->constant);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_sbiw(PLAIN_ARGUMENTS)
{
    unsigned before = plain_pair(avr, plain->d);
    unsigned difference = before - plain->constant;

    avr->sreg[S_C] = difference >> 16 & 1U;
    avr->sreg[S_V] = (before & ~difference) >> 15 & 1U;
    return end_word(PLAIN_PASSED, difference);
}

uint64_t plain_dec(PLAIN_ARGUMENTS)
{
    return end_step(PLAIN_PASSED, (uint8_t)(avr->data[plain->d] - 1U), 0x7F);
}

uint64_t plain_neg(PLAIN_ARGUMENTS)
{
    avr->data[plain->d] = subtract(avr, 0, avr->data[plain->d], 0);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_cp(PLAIN_ARGUMENTS)
{
    (void)subtract(avr, avr->data[plain->d], avr->data[plain->r], 0);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_cpc(PLAIN_ARGUMENTS)
{
    (void)subtract_higher(avr, avr->data[plain->d], avr->data[plain->r]);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_cpi(PLAIN_ARGUMENTS)
{
    (void)subtract(avr, avr->data[plain->d], plain->constant, 0);
    return plain_ended(PLAIN_PASSED, 1, 1);
}

// ---- logic ----

uint64_t plain_and(PLAIN_ARGUMENTS)
{
    return end_logic(PLAIN_PASSED, avr->data[plain->d] & avr->data[plain->r]);
}

uint64_t plain_or(PLAIN_ARGUMENTS)
{
    return end_logic(PLAIN_PASSED, avr->data[plain->d] | avr->data[plain->r]);
}

uint64_t plain_eor(PLAIN_ARGUMENTS)
{
    return end_logic(PLAIN_PASSED, avr->data[plain->d] ^ avr->data[plain->r]);
}

uint64_t plain_andi(PLAIN_ARGUMENTS)
{
    return end_logic(PLAIN_PASSED, avr->data[plain->d] & plain->constant);
}

uint64_t plain_ori(PLAIN_ARGUMENTS)
{
    return end_logic(PLAIN_PASSED, avr->data[plain->d] | plain->constant);
}

uint64_t plain_com(PLAIN_ARGUMENTS)
{
    avr->sreg[S_C] = 1;
    return end_logic(PLAIN_PASSED, avr->data[plain->d] ^ 0xFFU);
}

// ---- shifts ----

uint64_t plain_asr(PLAIN_ARGUMENTS)
{
    return end_shift(PLAIN_PASSED, avr->data[plain->d] & 0x80U);
}

uint64_t plain_lsr(PLAIN_ARGUMENTS)
{
    return end_shift(PLAIN_PASSED, 0);
}

uint64_t plain_ror(PLAIN_ARGUMENTS)
{
    return end_shift(PLAIN_PASSED, (uint8_t)(avr->sreg[S_C] << 7));
}

// ---- products ----

uint64_t plain_mul(PLAIN_ARGUMENTS)
{
    return end_product(PLAIN_PASSED, avr->data[plain->d] * avr->data[plain->r]);
}

uint64_t plain_muls(PLAIN_ARGUMENTS)
{
    return end_product(PLAIN_PASSED,
                       (int8_t)avr->data[plain->d] * (int8_t)avr->data[plain->r]);
}

uint64_t plain_mulsu(PLAIN_ARGUMENTS)
{
    return end_product(PLAIN_PASSED, (int8_t)avr->data[plain->d] * avr->data[plain->r]);
}

// ---- bits ----

uint64_t plain_bst(PLAIN_ARGUMENTS)
{
    avr->sreg[S_T] = (avr->data[plain->d] & plain->constant) != 0;
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_bld(PLAIN_ARGUMENTS)
{
    unsigned others = avr->data[plain->d] & ~(unsigned)plain->constant;

    avr->data[plain->d] =
        (uint8_t)(others | (avr->sreg[S_T] != 0 ? plain->constant : 0U));
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_bset(PLAIN_ARGUMENTS)
{
    avr->sreg[plain->d] = 1;
    return plain_ended(PLAIN_PASSED, 1, 1);
}

uint64_t plain_bclr(PLAIN_ARGUMENTS)
{
    avr->sreg[plain->d] = 0;
    return plain_ended(PLAIN_PASSED, 1, 1);
}
