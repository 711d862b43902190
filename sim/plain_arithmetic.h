// SPDX-License-Identifier: MIT
//
// Plain instructions on registers and flags alone. simavr keeps each flag in a byte of its own, 0
// or 1. The I bit is no part of this: it lets interrupts in.
#pragma once

#include "plain_instruction.h"

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
