// SPDX-License-Identifier: MIT
//
// Plain instructions that go elsewhere in the program. A target that the flash does not have leaves
// the instruction to simavr. RETI is no plain one: it ends an interrupt.
#pragma once

#include "plain_instruction.h"

// Branches by one flag, and skips of the next instruction, which may have two words.
plain_execute plain_brbs, plain_brbc, plain_cpse, plain_sbrs, plain_sbrc;
// Jumps.
plain_execute plain_rjmp, plain_jmp, plain_ijmp;
// Calls push a return address of two bytes, or of three with a 22-bit program counter.
plain_execute plain_rcall, plain_call, plain_icall, plain_ret;
