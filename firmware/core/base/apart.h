// SPDX-License-Identifier: MIT
// What the compiler must not know, or must not do, so that an image becomes smaller or faster. None
// of these words changes what a function computes. Each use was measured, by size and by stack; a
// new compiler may make some of them useless.
//
//     word               where it works                what it does
//     APART              every image                   the function is never inlined
//     APART_SMALL        built for size (the Uno)      APART; elsewhere always inlined
//     APART_LARGE        built for speed               APART; elsewhere the compiler decides
//     BY_POINTER         every image                   members are reached by the pointer
//     BY_POINTER_SMALL   built for size                BY_POINTER; elsewhere nothing
//     BY_BYTE            every image                   a byte is tested as a byte
#pragma once

// APART: the function stays a function of its own. There are two reasons for APART. Inlined at its
// one call, the function would take more registers than there are, and keeping values in memory
// costs more than the call. Or the function's stack frame would become a part of its caller's, and
// so lie below every other function that the caller calls.
//
//     static APART void rarely(void) ...
#define APART __attribute__((noinline))

// BY_POINTER: the compiler shall not know which object this pointer points to. Where the compiler
// knows the object, it addresses each member absolutely, and such an instruction is twice as long
// on the AVR as one with a displacement from a pointer. BY_POINTER is for functions that use
// several members, all of them within 64 bytes of the pointer.
//
//     struct feed *feed = &axis->feed;
//     BY_POINTER(feed);
#define BY_POINTER(pointer) __asm__("" : "+r"(pointer))

// BY_BYTE: the compiler shall not know that this byte is a part of a word. The compiler tests a bit
// of a byte by one instruction, but a bit of a word that it knows by up to ten.
#define BY_BYTE(byte) BY_POINTER(byte)

// BY_POINTER_SMALL: BY_POINTER where the image is built for size alone. Elsewhere BY_POINTER would
// cost time, and the word does nothing.
#if defined(__OPTIMIZE_SIZE__)
#define BY_POINTER_SMALL(pointer) BY_POINTER(pointer)
#else
#define BY_POINTER_SMALL(pointer)
#endif

// APART_SMALL: APART where the image is built for size alone. Elsewhere the call would cost time,
// and the function becomes a part of each caller.
#if defined(__OPTIMIZE_SIZE__)
#define APART_SMALL APART
#else
#define APART_SMALL inline __attribute__((always_inline))
#endif

// APART_LARGE: APART where the image is built for speed. Where the image is built for size alone,
// the function takes less flash, or less stack, inside its caller.
#if defined(__OPTIMIZE_SIZE__)
#define APART_LARGE
#else
#define APART_LARGE APART
#endif
