// SPDX-License-Identifier: MIT
//
// A plain instruction (plain.h) after it was decoded, and what the functions that execute one have
// in common. Flags and cycles are those of the AVR instruction set manual.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <sim_avr.h>

struct plain;

// How an instruction ended. It is returned rather than written to the part, because the next one
// waits for it: two registers of the PC are much faster than its memory.
struct plain_end {
    const struct plain *next; // NULL: nothing has changed, these operands make it one for simavr
    uint64_t cycles;
};

// Executes an instruction: results and flags. The program counter and the cycle are plain_run's.
typedef struct plain_end plain_execute(avr_t *avr, const struct plain *plain);

// A decoded instruction, one of an array with an element for each word of the flash.
struct plain {
    plain_execute *execute;
    uint8_t d, r;     // registers: destination and source, or the pointer's low half
    uint8_t constant; // operand K, displacement q or a mask of one bit
    uint8_t words;    // that a skip passes over
    uint32_t target;  // address in flash or RAM (bytes)
    uint32_t word;    // its own place
};

static inline struct plain_end plain_refused(void)
{
    return (struct plain_end){NULL, 0};
}

// The last act of an instruction of so many words that took so many cycles.
static inline struct plain_end
plain_ended(const struct plain *plain, unsigned words, unsigned cycles)
{
    return (struct plain_end){plain + words, cycles};
}

// The same of one that goes on at this flash address (bytes).
static inline struct plain_end
plain_jumped(const struct plain *plain, uint32_t target, unsigned cycles)
{
    return (struct plain_end){plain - plain->word + target / 2, cycles};
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
