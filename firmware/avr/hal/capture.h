// SPDX-License-Identifier: MIT
// Input capture of one timer: hardware holds the count of an edge, the handler says in which period
// it fell, because the counter restarts in every period.
//
//     edge        hardware copies the counter to ICRn and requests the interrupt
//     handler     notes ICRn, counter, flags and what the step engine has done
//     main loop   capture_take(): which period, which count; clears BUSY
//     second edge before that: only OVERRUN is set
//
// The pixel clock has a queue and a handler of its own (pixel_clock_isr.S).
#pragma once

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>
#include <stdint.h>

#include "avr/hal/step_isr.h" // step_engines
#include "hal/pixel_clock.h"  // struct pixel_capture

// What the handler saw; capture_take() makes sense of it. The handler writes it while `waiting` is
// false, the main loop reads it while `waiting` is true.
struct capture {
    // The other members are complete, and the main loop has not taken them.
    volatile bool waiting;
    // Count of the timer at the edge, ticks from the start of its period.
    uint16_t captured;
    uint16_t counter; // a little later, between two looks at the flags
    uint8_t flags_before;
    uint8_t flags_after;
    uint8_t tail; // struct engine_sample, at the same time
    int8_t left;
    int8_t cut;
    uint16_t idle_count;
};

// The capture interrupt of `timer` into struct capture `name`, up to where it lets others in; what
// follows is name##_body. `sample`: assembly that may use r24.
//
// As short as can be with interrupts off, 13 cycles and the sample's: the step interrupts come
// first. An edge that finds the one before it not taken is noted only, so that a noisy input cannot
// nest this. The instruction behind an SEI runs before any interrupt: it must not be the next CLI.
// The linker makes RJMP of JMP, because the body is near.
#define CAPTURE_ENTRY(name, timer, busy, overrun, sample, ...)                           \
    static struct capture name;                                                          \
    static void name##_body(void) __asm__("__vector_" #name "_body")                     \
        __attribute__((signal, used));                                                   \
    ISR(TIMER##timer##_CAPT_vect, ISR_NAKED)                                             \
    {                                                                                    \
        __asm__ volatile("sbic %[flags], %[is_busy]\n\t"                                 \
                         "rjmp 1f\n\t"                                                   \
                         "sbi %[flags], %[is_busy]\n\t" sample "jmp __vector_" #name     \
                         "_body\n"                                                       \
                         "1: sbi %[flags], %[one_more]\n\t"                              \
                         "reti"                                                          \
                         :                                                               \
                         : [is_busy] "I"(busy), [one_more] "I"(overrun), __VA_ARGS__);   \
    }

// The sample is taken at once, with interrupts off, 62 cycles in all: right as long as the handler
// is entered within a period, whatever keeps its body from its turn. For an input that may have an
// edge at the shortest periods of several axes, and seldom has one.
// Budget: 120 cycles and `note`.
#define CAPTURE_HANDLER_AT_ONCE(name, timer, axis, busy, overrun, note)                  \
    CAPTURE_ENTRY(name,                                                                  \
                  timer,                                                                 \
                  busy,                                                                  \
                  overrun,                                                               \
                  "push r24\n\t"                                                         \
                  "lds r24, %[edge]\n\t"                                                 \
                  "sts %[captured], r24\n\t"                                             \
                  "lds r24, %[edge] + 1\n\t"                                             \
                  "sts %[captured] + 1, r24\n\t"                                         \
                  "in r24, %[timer_flags]\n\t"                                           \
                  "sts %[before], r24\n\t"                                               \
                  "lds r24, %[count]\n\t"                                                \
                  "sts %[counter], r24\n\t"                                              \
                  "lds r24, %[count] + 1\n\t"                                            \
                  "sts %[counter] + 1, r24\n\t"                                          \
                  "in r24, %[timer_flags]\n\t"                                           \
                  "sts %[after], r24\n\t"                                                \
                  "lds r24, %[train_high]\n\t"                                           \
                  "sts %[top] + 1, r24\n\t"                                              \
                  "lds r24, %[engine_tail]\n\t"                                          \
                  "sts %[tail], r24\n\t"                                                 \
                  "lds r24, %[engine_left]\n\t"                                          \
                  "sts %[left], r24\n\t"                                                 \
                  "lds r24, %[engine_cut]\n\t"                                           \
                  "sts %[cut], r24\n\t"                                                  \
                  "lds r24, %[engine_idle]\n\t"                                          \
                  "sts %[idle], r24\n\t"                                                 \
                  "lds r24, %[engine_idle] + 1\n\t"                                      \
                  "sts %[idle] + 1, r24\n\t"                                             \
                  "sei\n\t"                                                              \
                  "pop r24\n\t",                                                         \
                  [flags] "I"(_SFR_IO_ADDR(GPIOR0)),                                     \
                  [timer_flags] "I"(_SFR_IO_ADDR(TIFR##timer)),                          \
                  [edge] "n"(_SFR_MEM_ADDR(ICR##timer)),                                 \
                  [count] "n"(_SFR_MEM_ADDR(TCNT##timer)),                               \
                  [top] "n"(_SFR_MEM_ADDR(OCR##timer##A)),                               \
                  [captured] "i"(&(name).captured),                                      \
                  [before] "i"(&(name).flags_before),                                    \
                  [counter] "i"(&(name).counter),                                        \
                  [after] "i"(&(name).flags_after),                                      \
                  [tail] "i"(&(name).tail),                                              \
                  [left] "i"(&(name).left),                                              \
                  [cut] "i"(&(name).cut),                                                \
                  [idle] "i"(&(name).idle_count),                                        \
                  [train_high] "i"(&step_engines[axis].train_high),                      \
                  [engine_tail] "i"(&step_engines[axis].tail),                           \
                  [engine_left] "i"(&step_engines[axis].left),                           \
                  [engine_cut] "i"(&step_engines[axis].cut),                             \
                  [engine_idle] "i"(&step_engines[axis].idle_count))                     \
    static void name##_body(void)                                                        \
    {                                                                                    \
        (note);                                                                          \
        (name).waiting = true;                                                           \
    }

// A counter read between two looks at the overflow flag has wrapped before it was read, if the flag
// appeared between them and the counter is still below this.
#define CAPTURE_JUST_WRAPPED_TICKS 16

// The period in which the edge lies, by its distance from the period that the engine loaded last:
// 0 is m + 1, 1 is m, 2 is the one before m. overflow: the mask of the timer's overflow flag. m is
// the period whose interrupt was served last; it loaded m + 1.
//
//     served:      m         (m + 1 begins, overflow pending)
//     counter   ---|---------------|------
//     edge in m: no overflow pending, or the captured value is beyond the counter
//     edge in m + 1: overflow pending and the captured value is not beyond the counter
static inline uint8_t capture_back(const struct capture *source, uint8_t overflow)
{
    bool wrapped = (source->flags_before & overflow) != 0 ||
                   ((source->flags_after & overflow) != 0 &&
                    source->counter < CAPTURE_JUST_WRAPPED_TICKS);

    if (wrapped) {
        return source->captured <= source->counter ? 0 : 1;
    }
    return source->captured > source->counter ? 2 : 1;
}

// Take the capture that waits. Returns false when there is none. *capture gets the count, how many
// periods the edge lies back from the one that the engine loaded last, and the sample. busy: the
// source's BUSY bit of GPIOR0. Main loop only, interrupts on.
static inline bool capture_take(struct capture *source,
                                struct pixel_capture *capture,
                                uint8_t busy)
{
    if (!source->waiting) {
        return false;
    }
    // The overflow flag is bit 0 of every timer's flags.
    capture->back = capture_back(source, _BV(TOV1));
    capture->ticks = source->captured;
    capture->sample = step_engine_sample_of(
        source->tail, source->left, source->cut, source->idle_count);
    source->waiting = false;
    GPIOR0 &= (uint8_t)~_BV(busy);
    return true;
}
