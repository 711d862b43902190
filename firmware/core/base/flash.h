// SPDX-License-Identifier: MIT
// Constant tables that take no RAM: avr-gcc copies constants there unless told otherwise.
//
//     static const uint16_t table[] IN_FLASH = {...};
//     word = flash_word(&table[i]);               table[i] would read RAM on the AVR
//
// On a processor with one memory for both, IN_FLASH is nothing and the functions are plain reads.
// The functions reach the first 64 KB of flash, where the linker puts such tables. They may be
// called from any context.
#pragma once

#include <stdint.h>

#if defined(__AVR__)

// Write IN_FLASH after the name of a constant, and the constant stays in flash. Read the constant
// by the functions below only.
#define IN_FLASH __attribute__((__progmem__))

// IN_FLASH for a large table: it lies after the step interrupts, which have to be near the vectors.
#define IN_FLASH_BEHIND __attribute__((section(".lowtext.tables")))

// The byte at this address of a table in flash.
static inline char flash_char(const char *at)
{
    char byte;

    __asm__("lpm %0, Z" : "=r"(byte) : "z"(at));
    return byte;
}

// As flash_char(), and advances *at to the next byte.
static inline char flash_next(const char **at)
{
    const char *from = *at;
    char byte;

    __asm__("lpm %0, Z+" : "=r"(byte), "+z"(from));
    *at = from;
    return byte;
}

// The word at this address of a table in flash, low byte first as the compiler stores it.
static inline uint16_t flash_word(const uint16_t *at)
{
    uint16_t word;

    __asm__("lpm %A0, Z+\n\t"
            "lpm %B0, Z"
            : "=&r"(word), "+z"(at));
    return word;
}

#else

// One memory: the same names, plain reads.
#define IN_FLASH
#define IN_FLASH_BEHIND

static inline char flash_char(const char *at)
{
    return *at;
}

static inline char flash_next(const char **at)
{
    return *(*at)++;
}

static inline uint16_t flash_word(const uint16_t *at)
{
    return *at;
}

#endif

// Copy `bytes` (1..255) of a table in flash to RAM. 0 is forbidden: the loop would copy 256.
static inline void flash_copy(void *to, const void *from, uint8_t bytes)
{
    char *byte = to;
    const char *at = from;

    do {
        *byte++ = flash_next(&at);
    } while (--bytes != 0);
}
