// SPDX-License-Identifier: MIT
//
// What the decoder (plain.c) chooses from: one function for each kind of plain instruction. Flags
// and cycles are those of the AVR instruction set manual.
#pragma once

#include "plain.h"

// The last act of an instruction of so many words that took so many cycles.
static inline bool plain_ended(avr_t *avr, unsigned words, unsigned cycles)
{
    avr->pc += 2 * words;
    avr->cycle += cycles;
    return true;
}

// The same of one that goes on at this flash address (bytes).
static inline bool plain_jumped(avr_t *avr, uint32_t target, unsigned cycles)
{
    avr->pc = target;
    avr->cycle += cycles;
    return true;
}

// The pair of registers, or the stack pointer, with its low half at this data address.
static inline uint16_t plain_pair(const avr_t *avr, unsigned low)
{
    return (uint16_t)(avr->data[low] | avr->data[low + 1] << 8);
}

static inline void plain_set_pair(avr_t *avr, unsigned low, unsigned value)
{
    avr->data[low] = (uint8_t)value;
    avr->data[low + 1] = (uint8_t)(value >> 8);
}

// RAM that is nothing but memory: neither registers nor I/O, and there at all.
static inline bool plain_is_ram(const avr_t *avr, uint32_t address)
{
    return address > avr->ioend && address <= avr->ramend;
}

// ---- plain_arithmetic.c ----

// Copies, which leave the flags alone.
plain_execute plain_nop, plain_mov, plain_movw, plain_ldi, plain_swap;
// Sums. ADIW takes a pair of registers and two cycles.
plain_execute plain_add, plain_adc, plain_adiw, plain_inc;
// Differences. SBC and SBCI leave Z clear if a lower byte was not zero.
plain_execute plain_sub, plain_sbc, plain_subi, plain_sbci, plain_sbiw;
plain_execute plain_cp, plain_cpc, plain_cpi; // of which only the flags remain
// Steps and signs. DEC and INC leave C alone.
plain_execute plain_dec, plain_neg;
// Logic. V becomes 0.
plain_execute plain_and, plain_or, plain_eor, plain_andi, plain_ori, plain_com;
// Shifts to the right. Those to the left are ADD and ADC of a register to itself.
plain_execute plain_asr, plain_lsr, plain_ror;
// Products, into r1:r0: both unsigned, both signed, the first signed.
plain_execute plain_mul, plain_muls, plain_mulsu;
// Bits: T from a register and back, and the flags but I (SEC, CLT and the like).
plain_execute plain_bst, plain_bld, plain_bset, plain_bclr;

// ---- plain_flow.c ----

// Branches by one flag, and skips of the next instruction, which may have two words.
plain_execute plain_brbs, plain_brbc, plain_cpse, plain_sbrs, plain_sbrc;
// Jumps.
plain_execute plain_rjmp, plain_jmp, plain_ijmp;
// Calls push a return address of two bytes, or of three with a 22-bit program counter.
plain_execute plain_rcall, plain_call, plain_icall, plain_ret;

// ---- plain_memory.c ----

// Accesses to RAM: "up" adds one to the pointer behind the access, "down" takes one off before it.
plain_execute plain_lds, plain_ldd, plain_ld_up, plain_ld_down, plain_pop;
plain_execute plain_sts, plain_std, plain_st_up, plain_st_down, plain_push;
// Reads of the flash's first 64 KB by way of Z.
plain_execute plain_lpm, plain_lpm_up;
