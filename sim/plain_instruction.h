// SPDX-License-Identifier: MIT
//
// A plain instruction (plain.h) after it was decoded, and what the functions that execute one have
// in common. Flags and cycles are those of the AVR instruction set manual.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

struct plain;

// Executes an instruction, results and flags, and calls the one behind it with the place in the
// program and the cycle as arguments: as the last act, so that the compiler makes a jump of the
// call and keeps both in registers of the PC. In the part's memory each instruction would wait for
// what the one before it has stored there. Returns the cycle in which the series has ended.
#define PLAIN_ARGUMENTS                                                                  \
    avr_t *avr, const struct plain *plain, uint64_t now, uint64_t until
#define PLAIN_PASSED avr, plain, now, until
typedef uint64_t plain_execute(PLAIN_ARGUMENTS);

// In the cycle that is returned: the operands of the next instruction make it one for simavr.
#define PLAIN_REFUSED (1ULL << 63)

// A decoded instruction, one of an array with an element for each word of the flash.
struct plain {
    plain_execute *execute;
    uint8_t d, r;     // registers: destination and source, or the pointer's low half
    uint8_t constant; // operand K, displacement q or a mask of one bit
    uint8_t words;    // that a skip passes over
    uint32_t target;  // address in flash or RAM (bytes)
    uint32_t word;    // its own place
};

// The series ends before this instruction.
static inline uint64_t plain_stop(avr_t *avr, const struct plain *plain, uint64_t now)
{
    avr->pc = 2 * plain->word;
    return now;
}

// The same because of this instruction, which has changed nothing.
static inline uint64_t plain_refused(PLAIN_ARGUMENTS)
{
    (void)until;
    return plain_stop(avr, plain, now) | PLAIN_REFUSED;
}

static inline uint64_t plain_go_on(PLAIN_ARGUMENTS)
{
    return (now < until) ? plain->execute(PLAIN_PASSED) : plain_stop(avr, plain, now);
}

// The last act of an instruction of so many words that took so many cycles.
static inline uint64_t plain_ended(PLAIN_ARGUMENTS, unsigned words, unsigned cycles)
{
    return plain_go_on(avr, plain + words, now + cycles, until);
}

// The same of one that goes on at this flash address (bytes).
static inline uint64_t plain_jumped(PLAIN_ARGUMENTS, uint32_t target, unsigned cycles)
{
    return plain_go_on(avr, plain - plain->word + target / 2, now + cycles, until);
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
