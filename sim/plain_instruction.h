// SPDX-License-Identifier: MIT
//
// A plain instruction (plain.h) after it was decoded, and what the functions that execute one have
// in common. Flags and cycles are those of the AVR instruction set manual.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

struct plain;

// Executes an instruction: results, flags, program counter and cycles. False, and nothing has
// changed, if these operands make it one for simavr.
typedef bool plain_execute(avr_t *avr, const struct plain *plain);

// A decoded instruction.
struct plain {
    plain_execute *execute;
    uint8_t d, r;     // registers: destination and source, or the pointer's low half
    uint8_t constant; // operand K, displacement q or a mask of one bit
    uint8_t words;    // that a skip passes over
    uint32_t target;  // address in flash or RAM (bytes)
};

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
