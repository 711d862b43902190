// SPDX-License-Identifier: MIT
// Constant tables that take no RAM. avr-gcc copies every constant into RAM unless a section says
// otherwise, and a table in flash is read by other instructions than a table in RAM. This header
// hides both, so that portable code has its tables in flash on the AVR.
//
//     static const uint16_t table[] IN_FLASH = {...};
//     word = flash_word(&table[i]);               table[i] would read RAM on the AVR
//
// On a processor with one memory for both, IN_FLASH is nothing and the functions are plain reads.
//
//     flash   | vectors | IN_FLASH | step interrupts, IN_FLASH_BEHIND | other code ...
//             0                                              within the first 64 KB
//
// The functions reach the first 64 KB of flash, where the linker puts such tables. They have no
// state and may be called from any context. They check nothing: the caller knows that the address
// lies inside a table.
#pragma once

#include <stdint.h>

#if defined(__AVR__)

// Write IN_FLASH after the name of a constant, and the constant stays in flash. Read the constant
// by the functions below only.
#define IN_FLASH __attribute__((__progmem__))

// IN_FLASH for a large table. The table lies after the step interrupts, which have to be near the
// vectors: among the small tables it would push them away.
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

// One memory for constants and variables: the same names, plain reads.
#define IN_FLASH
#define IN_FLASH_BEHIND

// The byte at this address.
static inline char flash_char(const char *at)
{
    return *at;
}

// As flash_char(), and advances *at to the next byte.
static inline char flash_next(const char **at)
{
    return *(*at)++;
}

// The word at this address, in the byte order of the processor.
static inline uint16_t flash_word(const uint16_t *at)
{
    return *at;
}

#endif

// Copy `bytes` bytes (1..255) of a table in flash to RAM. 0 is forbidden: the loop would copy 256.
static inline void flash_copy(void *to, const void *from, uint8_t bytes)
{
    char *byte = to;
    const char *at = from;

    do {
        *byte++ = flash_next(&at);
    } while (--bytes != 0);
}
