// SPDX-License-Identifier: MIT
//
// Plain instructions that read or write RAM, the stack or the flash. An address that is not
// plain RAM (an I/O register, or none at all) leaves the instruction to simavr.
#pragma once

#include "plain_instruction.h"

// Accesses to RAM: "up" adds one to the pointer behind the access, "down" takes one off before it.
plain_execute plain_lds, plain_ldd, plain_ld_up, plain_ld_down, plain_pop;
plain_execute plain_sts, plain_std, plain_st_up, plain_st_down, plain_push;
// Reads of the flash's first 64 KB by way of Z.
plain_execute plain_lpm, plain_lpm_up;
