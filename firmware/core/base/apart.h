// SPDX-License-Identifier: MIT
// APART: stays a function of its own. Inlined at its one call it would take more registers than
// there are, and what is then kept in memory costs more than the call. Or what it keeps on the
// stack would lie below everything else that its caller calls. By size and stack, measured.
//
//     #include "base/apart.h"
//     static APART void rarely(void) ...
#pragma once

#define APART __attribute__((noinline))

// BY_POINTER: the compiler shall not know which object this pointer points to. Where it knows, it
// takes each member at an address of its own, and on the AVR that is twice as long as a place
// behind a pointer. For objects with several members at hand, within 64 bytes. By size, measured.
//
//     struct feed *feed = &axis->feed;
//     BY_POINTER(feed);
#define BY_POINTER(pointer) __asm__("" : "+r"(pointer))

// BY_BYTE: the compiler shall not know that this byte is a part of a word. It tests a bit of a byte
// by one instruction, and of a word that it knows by up to ten. By size, measured.
#define BY_BYTE(byte) BY_POINTER(byte)

// BY_POINTER_SMALL: BY_POINTER where the image is built for size alone; elsewhere it costs time.
#if defined(__OPTIMIZE_SIZE__)
#define BY_POINTER_SMALL(pointer) BY_POINTER(pointer)
#else
#define BY_POINTER_SMALL(pointer)
#endif

// APART_SMALL: APART where the image is built for size alone; elsewhere the call costs time, and
// the function becomes a part of each caller.
#if defined(__OPTIMIZE_SIZE__)
#define APART_SMALL APART
#else
#define APART_SMALL inline __attribute__((always_inline))
#endif

// APART_LARGE: APART where the image is built for speed; where it is built for size alone the
// function takes less flash, or less stack, inside its caller.
#if defined(__OPTIMIZE_SIZE__)
#define APART_LARGE
#else
#define APART_LARGE APART
#endif
