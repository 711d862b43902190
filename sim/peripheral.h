// SPDX-License-Identifier: MIT
//
// What the models of the part's peripherals share: how a model finds the peripheral of libsimavr
// that it replaces, raises an interrupt, schedules its next effect, and refuses what it does not
// model. The models include this header; nothing else needs it, except the board that fills in a
// struct peripheral_host.
#pragma once

#include <stdint.h>

#include <sim_avr.h>

// What every model reports to its board. `board` is passed back unchanged.
struct peripheral_host {
    void *board;
    // An interrupt flag has come up at this cycle; the interrupt itself is raised just afterwards.
    void (*flag)(void *board, uint8_t vector, uint64_t cycle);
    // The program uses something that is not modelled: the run must stop with this one-line text.
    void (*refuse)(void *board, const char *text);
};

// The next peripheral of this kind ("timer", "uart", ...) in libsimavr's list, `from` included.
// NULL behind the last one. Start with avr->io_port.
avr_io_t *peripheral_next(avr_io_t *from, const char *kind);

// The part's only peripheral of this kind. Every supported part has it: if libsimavr's does not,
// prints one line that calls it `name` and aborts.
void *peripheral_find(const avr_t *avr, const char *kind, const char *name);

// Prints that libsimavr's part has no peripheral `name`, and aborts.
_Noreturn void peripheral_missing(const char *name);

// Reports the flag with its exact cycle, which libsimavr does not know, then raises the interrupt.
void peripheral_raise(const struct peripheral_host *host,
                      avr_t *avr,
                      avr_int_vector_t *vector,
                      uint64_t cycle);

// Stops the run with this text, which begins with the peripheral's name.
__attribute__((format(printf, 2, 3))) void peripheral_refuse(
    const struct peripheral_host *host, const char *format, ...);

// Cycles of a time that does not come from the part's own clock.
static inline uint64_t peripheral_cycles_of_us(const avr_t *avr, uint64_t us)
{
    return us * (avr->frequency / 1000000U);
}

// The earlier of two cycles; UINT64_MAX stands for never.
static inline uint64_t peripheral_earlier(uint64_t a, uint64_t b)
{
    return (a < b) ? a : b;
}

// Lets libsimavr call `callback` at the end of the instruction in which cycle `due` falls; a cycle
// that is over counts as now. Replaces an earlier request for the same callback and parameter. The
// callback returns the next due cycle, or 0.
static inline void peripheral_schedule(avr_t *avr,
                                       uint64_t due,
                                       avr_cycle_timer_t callback,
                                       void *param)
{
    avr_cycle_timer_register(
        avr, (due > avr->cycle) ? due - avr->cycle : 0, callback, param);
}
