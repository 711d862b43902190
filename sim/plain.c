// SPDX-License-Identifier: MIT

#include "plain.h"

#include <stddef.h>
#include <stdlib.h>

#include "plain_arithmetic.h"
#include "plain_flow.h"
#include "plain_memory.h"

#define POINTER_X 26U
#define POINTER_Y 28U
#define POINTER_Z 30U
#define S_BITS    7U

// A place in flash: its opcode and the word behind it.
struct place {
    uint32_t address; // bytes
    uint16_t opcode, next;
};

// Takes the operands out of an opcode.
typedef void take_operands(struct plain *plain, const struct place *place);

// ---- operands ----

static uint8_t five_d(uint16_t opcode)
{
    return opcode >> 4 & 0x1FU;
}

static uint8_t four_d(uint16_t opcode)
{
    return (uint8_t)(16U + (opcode >> 4 & 0xFU));
}

static int sign_extend(unsigned value, unsigned bits)
{
    unsigned sign = 1U << (bits - 1U);

    return (int)((value & (2 * sign - 1U)) ^ sign) - (int)sign;
}

static uint32_t relative(const struct place *place, int words)
{
    return place->address + 2U + 2U * (uint32_t)words;
}

static uint32_t absolute(const struct place *place)
{
    uint32_t high = (uint32_t)(place->opcode >> 3 & 0x3EU) | (place->opcode & 1U);

    return 2U * (high << 16 | place->next);
}

static bool has_two_words(uint16_t opcode)
{
    bool direct = (opcode & 0xFC0FU) == 0x9000U;   // LDS, STS
    bool far_away = (opcode & 0xFE0CU) == 0x940CU; // JMP, CALL

    return direct || far_away;
}

static void take_nothing(struct plain *plain, const struct place *place)
{
    (void)plain;
    (void)place;
}

static void take_d(struct plain *plain, const struct place *place)
{
    plain->d = five_d(place->opcode);
}

static void take_d_r(struct plain *plain, const struct place *place)
{
    plain->d = five_d(place->opcode);
    plain->r = (uint8_t)((place->opcode >> 5 & 0x10U) | (place->opcode & 0xFU));
    plain->words = has_two_words(place->next) ? 2 : 1;
}

static void take_pairs(struct plain *plain, const struct place *place)
{
    plain->d = (uint8_t)(2U * (place->opcode >> 4 & 0xFU));
    plain->r = (uint8_t)(2U * (place->opcode & 0xFU));
}

static void take_upper(struct plain *plain, const struct place *place)
{
    plain->d = four_d(place->opcode);
    plain->r = (uint8_t)(16U + (place->opcode & 0xFU));
}

static void take_d_k(struct plain *plain, const struct place *place)
{
    plain->d = four_d(place->opcode);
    plain->constant = (uint8_t)((place->opcode >> 4 & 0xF0U) | (place->opcode & 0xFU));
}

static void take_pair_k(struct plain *plain, const struct place *place)
{
    plain->d = (uint8_t)(24U + (place->opcode >> 3 & 6U));
    plain->constant = (uint8_t)((place->opcode >> 2 & 0x30U) | (place->opcode & 0xFU));
}

static void take_bit(struct plain *plain, const struct place *place)
{
    plain->d = five_d(place->opcode);
    plain->constant = (uint8_t)(1U << (place->opcode & 7U));
    plain->words = has_two_words(place->next) ? 2 : 1;
}

static void take_flag(struct plain *plain, const struct place *place)
{
    plain->d = place->opcode >> 4 & 7U;
}

static void take_branch(struct plain *plain, const struct place *place)
{
    plain->d = place->opcode & 7U;
    plain->target = relative(place, sign_extend(place->opcode >> 3, 7));
}

static void take_relative(struct plain *plain, const struct place *place)
{
    plain->target = relative(place, sign_extend(place->opcode, 12));
}

static void take_absolute(struct plain *plain, const struct place *place)
{
    plain->target = absolute(place);
}

static void take_direct(struct plain *plain, const struct place *place)
{
    plain->d = five_d(place->opcode);
    plain->target = place->next;
}

static void take_displaced(struct plain *plain, const struct place *place)
{
    unsigned opcode = place->opcode;

    plain->d = five_d(place->opcode);
    plain->r = (opcode & 8U) != 0 ? POINTER_Y : POINTER_Z;
    plain->constant =
        (uint8_t)((opcode >> 8 & 0x20U) | (opcode >> 7 & 0x18U) | (opcode & 7U));
}

// LD and ST: two bits name the pointer.
static void take_pointer(struct plain *plain, const struct place *place)
{
    static const uint8_t pointers[] = {POINTER_Z, 0, POINTER_Y, POINTER_X};

    plain->d = five_d(place->opcode);
    plain->r = pointers[place->opcode >> 2 & 3U];
}

// ---- opcodes ----

static const struct kind {
    uint16_t mask, value;
    plain_execute *execute;
    take_operands *take;
} kinds[] = {
    {0xFFFF, 0x0000, plain_nop, take_nothing},
    {0xFF00, 0x0100, plain_movw, take_pairs},
    {0xFF00, 0x0200, plain_muls, take_upper},
    {0xFF88, 0x0300, plain_mulsu, take_upper},
    {0xFC00, 0x0400, plain_cpc, take_d_r},
    {0xFC00, 0x0800, plain_sbc, take_d_r},
    {0xFC00, 0x0C00, plain_add, take_d_r},
    {0xFC00, 0x1000, plain_cpse, take_d_r},
    {0xFC00, 0x1400, plain_cp, take_d_r},
    {0xFC00, 0x1800, plain_sub, take_d_r},
    {0xFC00, 0x1C00, plain_adc, take_d_r},
    {0xFC00, 0x2000, plain_and, take_d_r},
    {0xFC00, 0x2400, plain_eor, take_d_r},
    {0xFC00, 0x2800, plain_or, take_d_r},
    {0xFC00, 0x2C00, plain_mov, take_d_r},
    {0xF000, 0x3000, plain_cpi, take_d_k},
    {0xF000, 0x4000, plain_sbci, take_d_k},
    {0xF000, 0x5000, plain_subi, take_d_k},
    {0xF000, 0x6000, plain_ori, take_d_k},
    {0xF000, 0x7000, plain_andi, take_d_k},
    {0xD200, 0x8000, plain_ldd, take_displaced},
    {0xD200, 0x8200, plain_std, take_displaced},
    {0xFE0F, 0x9000, plain_lds, take_direct},
    {0xFE0F, 0x9001, plain_ld_up, take_pointer},
    {0xFE0F, 0x9002, plain_ld_down, take_pointer},
    {0xFE0F, 0x9004, plain_lpm, take_d},
    {0xFE0F, 0x9005, plain_lpm_up, take_d},
    {0xFE0F, 0x9009, plain_ld_up, take_pointer},
    {0xFE0F, 0x900A, plain_ld_down, take_pointer},
    {0xFE0F, 0x900C, plain_ldd, take_pointer},
    {0xFE0F, 0x900D, plain_ld_up, take_pointer},
    {0xFE0F, 0x900E, plain_ld_down, take_pointer},
    {0xFE0F, 0x900F, plain_pop, take_d},
    {0xFE0F, 0x9200, plain_sts, take_direct},
    {0xFE0F, 0x9201, plain_st_up, take_pointer},
    {0xFE0F, 0x9202, plain_st_down, take_pointer},
    {0xFE0F, 0x9209, plain_st_up, take_pointer},
    {0xFE0F, 0x920A, plain_st_down, take_pointer},
    {0xFE0F, 0x920C, plain_std, take_pointer},
    {0xFE0F, 0x920D, plain_st_up, take_pointer},
    {0xFE0F, 0x920E, plain_st_down, take_pointer},
    {0xFE0F, 0x920F, plain_push, take_d},
    {0xFE0F, 0x9400, plain_com, take_d},
    {0xFE0F, 0x9401, plain_neg, take_d},
    {0xFE0F, 0x9402, plain_swap, take_d},
    {0xFE0F, 0x9403, plain_inc, take_d},
    {0xFE0F, 0x9405, plain_asr, take_d},
    {0xFE0F, 0x9406, plain_lsr, take_d},
    {0xFE0F, 0x9407, plain_ror, take_d},
    {0xFE0F, 0x940A, plain_dec, take_d},
    {0xFF8F, 0x9408, plain_bset, take_flag},
    {0xFF8F, 0x9488, plain_bclr, take_flag},
    {0xFFFF, 0x9409, plain_ijmp, take_nothing},
    {0xFFFF, 0x9508, plain_ret, take_nothing},
    {0xFFFF, 0x9509, plain_icall, take_nothing},
    {0xFE0E, 0x940C, plain_jmp, take_absolute},
    {0xFE0E, 0x940E, plain_call, take_absolute},
    {0xFF00, 0x9600, plain_adiw, take_pair_k},
    {0xFF00, 0x9700, plain_sbiw, take_pair_k},
    {0xFC00, 0x9C00, plain_mul, take_d_r},
    {0xF000, 0xC000, plain_rjmp, take_relative},
    {0xF000, 0xD000, plain_rcall, take_relative},
    {0xF000, 0xE000, plain_ldi, take_d_k},
    {0xFC00, 0xF000, plain_brbs, take_branch},
    {0xFC00, 0xF400, plain_brbc, take_branch},
    {0xFE08, 0xF800, plain_bld, take_bit},
    {0xFE08, 0xFA00, plain_bst, take_bit},
    {0xFE08, 0xFC00, plain_sbrc, take_bit},
    {0xFE08, 0xFE00, plain_sbrs, take_bit},
};

#define KINDS (sizeof kinds / sizeof kinds[0])

// ---- decoding ----

static uint64_t leave_to_simavr(PLAIN_ARGUMENTS)
{
    return plain_refused(PLAIN_PASSED);
}

static uint16_t word_at(const avr_t *avr, uint32_t address)
{
    return (uint16_t)(avr->flash[address] | avr->flash[address + 1] << 8);
}

// What the operands alone decide: the I bit, registers of I/O, jumps out of the flash.
static bool is_plain(const struct plain *plain, const avr_t *avr)
{
    if (plain->execute == plain_bset || plain->execute == plain_bclr) {
        return plain->d != S_I;
    }
    if (plain->execute == plain_lds || plain->execute == plain_sts) {
        return plain_is_ram(avr, plain->target);
    }
    return plain->target < avr->flashend;
}

static struct plain decode(const avr_t *avr, const struct place *place)
{
    struct plain plain = {.execute = leave_to_simavr};

    for (size_t i = 0; i < KINDS; i++) {
        if ((place->opcode & kinds[i].mask) == kinds[i].value) {
            plain.execute = kinds[i].execute;
            kinds[i].take(&plain, place);
            if (!is_plain(&plain, avr)) {
                plain.execute = leave_to_simavr;
            }
            return plain;
        }
    }
    return plain;
}

#define ERASED 0xFFFFU

// The last words stay simavr's, so that no plain instruction runs off the end of the flash.
#define LAST_BYTES 6U

static void decode_at(struct plain_program *program, const avr_t *avr, uint32_t address)
{
    struct plain *plain = &program->at[address / 2];

    *plain = (struct plain){.execute = leave_to_simavr};
    if (address + LAST_BYTES <= avr->flashend && word_at(avr, address) != ERASED) {
        *plain = decode(
            avr,
            &(struct place){address, word_at(avr, address), word_at(avr, address + 2U)});
    }
    plain->word = address / 2;
}

bool plain_decode(struct plain_program *program, const avr_t *avr)
{
    program->at = calloc(avr->flashend / 2U + 1U, sizeof *program->at);
    if (program->at == NULL) {
        return false;
    }
    for (uint32_t address = 0; address <= avr->flashend; address += 2) {
        decode_at(program, avr, address);
    }
    return true;
}

void plain_patched(struct plain_program *program, const avr_t *avr, uint32_t address)
{
    decode_at(program, avr, address);
    if (address > 0) {
        decode_at(program, avr, address - 2U);
    }
}

void plain_free(struct plain_program *program)
{
    free(program->at);
    program->at = NULL;
}
