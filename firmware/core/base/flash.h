// SPDX-License-Identifier: MIT
// Constant tables that take no RAM: avr-gcc copies constants there unless told otherwise.
#pragma once

#include <stdint.h>

#if defined(__AVR__)

#define IN_FLASH __attribute__((__progmem__))

// A byte of such a table.
static inline char flash_char(const char *at)
{
    char byte;

    __asm__("lpm %0, Z" : "=r"(byte) : "z"(at));
    return byte;
}

static inline uint16_t flash_word(const uint16_t *at)
{
    uint16_t word;

    __asm__("lpm %A0, Z+\n\t"
            "lpm %B0, Z"
            : "=&r"(word), "+z"(at));
    return word;
}

#else

#define IN_FLASH

static inline char flash_char(const char *at)
{
    return *at;
}

static inline uint16_t flash_word(const uint16_t *at)
{
    return *at;
}

#endif

// `bytes` (not 0) of such a table.
static inline void flash_copy(void *to, const void *from, uint8_t bytes)
{
    char *byte = to;
    const char *at = from;

    do {
        *byte++ = flash_char(at++);
    } while (--bytes != 0);
}
