// SPDX-License-Identifier: MIT
// Constant tables that take no RAM: avr-gcc copies constants there unless told otherwise.
#pragma once

#if defined(__AVR__)

#define IN_FLASH __attribute__((__progmem__))

// A byte of such a table.
static inline char flash_char(const char *at)
{
    char byte;

    __asm__("lpm %0, Z" : "=r"(byte) : "z"(at));
    return byte;
}

#else

#define IN_FLASH

static inline char flash_char(const char *at)
{
    return *at;
}

#endif
