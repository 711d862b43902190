// SPDX-License-Identifier: MIT
//
// Interrupt handlers of a linked image beside their twins in C.
//
// A run is one handler, from its vector to its RETI, instruction by instruction, over memory and
// registers of random content. Memory is of two kinds:
//
//  * shared: the registers of the hardware, and what other interrupts write. The twin is asked
//    after the handler and reads what the handler has read; each access must be the twin's, in
//    order, with interrupts on or off as the twin has them.
//  * own: all other memory. The twin works on a copy, which must be equal in the end.
//
// The registers of the interrupted program, its flags and its stack are as they were. Wherever an
// interrupt may come, r2 to r6, which belong to the step interrupts, change, and what the run lets
// interrupts change.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// ---- the image ----

void bench_open(const char *image_path, const char *part_name);
// Data address of a variable, program address of a function.
uint16_t bench_variable(const char *name);
uint32_t bench_function(const char *name);

// ---- a run ----

struct shared_memory {
    uint16_t first, bytes;
};

// A function in C that a handler calls and that is not run: what it leaves is made up.
struct made_up {
    uint32_t function;
    bool interrupts_on;  // as it must be called
    void (*leave)(void); // may be NULL
    // Ends by RETI and keeps all registers; else as the compiler's rules have it.
    bool is_signal;
};

struct handler {
    const char *name;
    uint8_t vector;
    const struct shared_memory
        *shared; // beside the hardware's registers; up to one of 0 bytes
    const struct made_up *made_up; // up to one of function 0
    void (*prepare)(void);         // puts what should not be quite random
    void (*interrupt)(void); // what interrupts may do, with what bench_put() changes
    void (*twin)(void);
};

// Runs a handler on other memory each time.
void bench_run(const struct handler *handler, unsigned runs);

// A random byte; a random byte of which each of the few marginal ones is likely.
uint8_t bench_noise(void);
uint8_t bench_margin(void);
void bench_put(uint16_t address, uint8_t value);
uint8_t bench_get(uint16_t address);

// ---- the twin's side ----

uint8_t twin_reads(uint16_t address);
void twin_writes(uint16_t address, uint8_t value);
// Single bits, by SBI, CBI, SBIC and SBIS or by a whole read.
void twin_sets(uint16_t address, uint8_t bit);
void twin_clears(uint16_t address, uint8_t bit);
bool twin_has(uint16_t address, uint8_t bit);
// Interrupts on, off.
void twin_opens(void);
void twin_closes(void);
// Own memory.
uint8_t *twin_own(uint16_t address);
uint16_t twin_word(uint16_t address);
void twin_put_word(uint16_t address, uint16_t value);
// The made-up function is called here: its changes of own memory are the twin's, too.
void twin_calls(const struct made_up *function);
