// SPDX-License-Identifier: MIT
// Input capture of one timer: hardware holds the count of an edge, the handler says in which period
// it fell, because the counter restarts in every period.
//
//     edge        hardware copies the counter to ICRn and requests the interrupt
//     handler     notes ICRn, counter, flags and what the step engine has done
//     main loop   capture_take(): which period, which count; clears BUSY
//     second edge before that: only OVERRUN is set
//
// The pixel clock has a queue: its handler places an edge at once, and is BUSY for itself alone.
#pragma once

#include <avr/interrupt.h>
#include <avr/io.h>
#include <stdbool.h>
#include <stddef.h> // offsetof
#include <stdint.h>
#include <util/atomic.h>

#include "config.h"           // CONFIG_AXES, CONFIG_CLOCK_EDGES
#include "hal/avr/step_isr.h" // step_engines
#include "hal/pixel_clock.h"  // struct pixel_capture
#if CONFIG_AXES > 1
#include "hal/avr/clock_units.h" // clock_look
#endif

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

// In flags_before: the axis was parked. idle_count then holds the coarse clock's low 16 bits, and
// the other members of the sample are what they were when the axis was parked.
#define CAPTURE_PARKED 0x80u

// A counter read between two looks at the overflow flag has wrapped before it was read, if the flag
// appeared between them and the counter is still below this.
#define CAPTURE_JUST_WRAPPED_TICKS 16u

// Bits of GPIOR0: BUSY from an edge on, until the main loop has taken it; OVERRUN when another edge
// came meanwhile.
#define CAPTURE_PIXEL_CLOCK_BUSY    0
#define CAPTURE_PIXEL_CLOCK_OVERRUN 1
#define CAPTURE_SWITCH_BUSY         2
#define CAPTURE_SWITCH_OVERRUN      3

// Low 16 bits of the coarse clock. The handler of a parked axis's edge calls this.
uint16_t capture_units_now(void);

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

// One edge of a queue, 7 bytes.
struct capture_entry {
    // Count of the timer at the edge, ticks from the start of its period.
    uint16_t captured;
    // struct engine_sample, a little later. Of the engine's `left` and `cut` one is 0.
    uint8_t tail;
    int8_t left_or_cut;
    uint16_t idle_count;
    // CAPTURE_CUT: `cut` is not 0. CAPTURE_WAS_PARKED: idle_count is the coarse clock's low 16
    // bits. CAPTURE_BACK: struct pixel_capture.
    uint8_t notes;
};

#define CAPTURE_BACK       0x03u
#define CAPTURE_WAS_PARKED 0x40u
#define CAPTURE_CUT        0x80u

// Edges that wait for the main loop. Both ends run freely.
struct capture_queue {
    volatile uint8_t head; // only the handler writes it
    volatile uint8_t tail; // only the main loop writes it
    // Edges that found the queue full; stays at 255. The main loop clears it.
    volatile uint8_t lost;
    struct capture_entry entries[CONFIG_CLOCK_EDGES];
};

_Static_assert(sizeof(struct capture_entry) == 7u &&
                   offsetof(struct capture_entry, tail) == 2u &&
                   offsetof(struct capture_entry, left_or_cut) == 3u &&
                   offsetof(struct capture_entry, idle_count) == 4u &&
                   offsetof(struct capture_entry, notes) == 6u,
               "known to CAPTURE_QUEUE_HANDLER");
_Static_assert(
    (CONFIG_CLOCK_EDGES & (CONFIG_CLOCK_EDGES - 1u)) == 0 && CONFIG_CLOCK_EDGES <= 16u,
    "CAPTURE_QUEUE_HANDLER masks the queue's index and shifts it by four bits");

// In CAPTURE_QUEUE_HANDLER behind the sample: what is noted of a parked axis.
#if CONFIG_AXES > 1
#define CAPTURE_UNLESS_PARKED                                                            \
    "lds r19, %[engine_state]\n\t"                                                       \
    "cpi r19, %[parked]\n\t"                                                             \
    "brne 7f\n\t"                                                                        \
    "push r0\n\t"                                                                        \
    "push r1\n\t"                                                                        \
    "clr r1\n\t"                                                                         \
    "push r30\n\t"                                                                       \
    "push r31\n\t"                                                                       \
    "call capture_units_now\n\t"                                                         \
    "pop r31\n\t"                                                                        \
    "pop r30\n\t"                                                                        \
    "pop r1\n\t"                                                                         \
    "pop r0\n\t"                                                                         \
    "std Z + 4, r24\n\t"                                                                 \
    "std Z + 5, r25\n\t"                                                                 \
    "ldi r24, %[was_parked] + 1\n\t"                                                     \
    "rjmp 6f\n\t"                                                                        \
    "7:\n\t"
#else
#define CAPTURE_UNLESS_PARKED ""
#endif

// The capture interrupt of `timer` into struct capture_queue `queue`. BUSY is set while the handler
// runs: an edge that comes meanwhile only sets OVERRUN, so that a noisy input cannot nest the
// handler. BUSY is cleared with interrupts off, by the last instruction but one.
//
// Interrupts are off for 13 cycles, as in CAPTURE_ENTRY, then for 9, and for 21 where the sample,
// the flags and the counter belong together. The sample is right as long as no more than one period
// began since the edge. Some 80 cycles lie between, and the step interrupts of other axes. In
// shorter periods the place of an edge may be off by periods; line zero never is: an axis at rest
// has long ones.
//
// The period of the edge is counted back from the one that the engine loaded last, m + 1, where m
// is the period whose interrupt was served last:
//
//     served:      m         (m + 1 begins, overflow pending)
//     counter   ---|---------------|------
//     0 or 1: the counter is in m + 1 (the flag was set before the counter was read, or it appeared
//     beside a count that has just wrapped) or in m; and 1 more when the captured value is beyond
//     the counter: the edge lies in the period before the counter's.
//
// Reading ICRn and TCNTn disturbs TEMP, which belongs to a run (step_isr.S): it is put back. Where
// the axis is parked, no interrupt of its own runs: the entry gets the coarse clock's units in the
// place of the idle count, and the other members are what they were when the axis was parked.
//
// Budget: 165 cycles; 215 where the axis is parked.
#define CAPTURE_QUEUE_HANDLER(queue, timer, axis, busy, overrun)                         \
    ISR(TIMER##timer##_CAPT_vect, ISR_NAKED)                                             \
    {                                                                                    \
        __asm__ volatile("sbic %[flags], %[is_busy]\n\t"                                 \
                         "rjmp 9f\n\t"                                                   \
                         "sbi %[flags], %[is_busy]\n\t"                                  \
                         "sei\n\t"                                                       \
                         "push r24\n\t"                                                  \
                         "in r24, __SREG__\n\t"                                          \
                         "push r24\n\t"                                                  \
                         "push r30\n\t"                                                  \
                         "push r31\n\t"                                                  \
                         "lds r24, %[head]\n\t"                                          \
                         "lds r30, %[oldest]\n\t"                                        \
                         "sub r30, r24\n\t"                                              \
                         "cpi r30, lo8(-%[size])\n\t"                                    \
                         "brne 1f\n\t"                                                   \
                         "lds r24, %[lost]\n\t"                                          \
                         "inc r24\n\t"                                                   \
                         "breq 7f\n\t"                                                   \
                         "sts %[lost], r24\n\t"                                          \
                         "7: rjmp 8f\n\t"                                                \
                         "1: andi r24, %[size] - 1\n\t"                                  \
                         "mov r30, r24\n\t"                                              \
                         "swap r30\n\t"                                                  \
                         "lsr r30\n\t"                                                   \
                         "sub r30, r24\n\t"                                              \
                         "ldi r31, 0\n\t"                                                \
                         "subi r30, lo8(-(%[entries]))\n\t"                              \
                         "sbci r31, hi8(-(%[entries]))\n\t"                              \
                         "push r18\n\t"                                                  \
                         "push r19\n\t"                                                  \
                         "push r20\n\t"                                                  \
                         "push r21\n\t"                                                  \
                         "push r22\n\t"                                                  \
                         "push r23\n\t"                                                  \
                         "push r25\n\t"                                                  \
                         "push r26\n\t"                                                  \
                         "push r27\n\t"                                                  \
                         "cli\n\t"                                                       \
                         "lds r20, %[edge]\n\t"                                          \
                         "lds r21, %[edge] + 1\n\t"                                      \
                         "lds r24, %[train_high]\n\t"                                    \
                         "sts %[top] + 1, r24\n\t"                                       \
                         "sei\n\t"                                                       \
                         "std Z + 0, r20\n\t"                                            \
                         "std Z + 1, r21\n\t"                                            \
                         "cli\n\t"                                                       \
                         "lds r22, %[engine_tail]\n\t"                                   \
                         "lds r23, %[engine_left]\n\t"                                   \
                         "lds r25, %[engine_cut]\n\t"                                    \
                         "lds r26, %[engine_idle]\n\t"                                   \
                         "lds r27, %[engine_idle] + 1\n\t"                               \
                         "in r18, %[timer_flags]\n\t"                                    \
                         "lds r20, %[count]\n\t"                                         \
                         "lds r21, %[count] + 1\n\t"                                     \
                         "in r24, %[timer_flags]\n\t"                                    \
                         "lds r19, %[train_high]\n\t"                                    \
                         "sts %[top] + 1, r19\n\t"                                       \
                         "sei\n\t"                                                       \
                         "std Z + 2, r22\n\t"                                            \
                         "or r23, r25\n\t"                                               \
                         "std Z + 3, r23\n\t"                                            \
                         "std Z + 4, r26\n\t"                                            \
                         "std Z + 5, r27\n\t" CAPTURE_UNLESS_PARKED "sbrc r18, 0\n\t"    \
                         "rjmp 2f\n\t"                                                   \
                         "sbrs r24, 0\n\t"                                               \
                         "rjmp 3f\n\t"                                                   \
                         "ldi r19, 0\n\t"                                                \
                         "cpi r20, %[just_wrapped]\n\t"                                  \
                         "cpc r21, r19\n\t"                                              \
                         "brsh 3f\n\t"                                                   \
                         "2: ldi r24, 0\n\t"                                             \
                         "rjmp 4f\n\t"                                                   \
                         "3: ldi r24, 1\n\t"                                             \
                         "4: ldd r18, Z + 0\n\t"                                         \
                         "ldd r19, Z + 1\n\t"                                            \
                         "cp r20, r18\n\t"                                               \
                         "cpc r21, r19\n\t"                                              \
                         "brsh 5f\n\t"                                                   \
                         "inc r24\n\t"                                                   \
                         "5: and r25, r25\n\t"                                           \
                         "breq 6f\n\t"                                                   \
                         "ori r24, %[cut]\n\t"                                           \
                         "6: std Z + 6, r24\n\t"                                         \
                         "lds r24, %[head]\n\t"                                          \
                         "inc r24\n\t"                                                   \
                         "sts %[head], r24\n\t"                                          \
                         "pop r27\n\t"                                                   \
                         "pop r26\n\t"                                                   \
                         "pop r25\n\t"                                                   \
                         "pop r23\n\t"                                                   \
                         "pop r22\n\t"                                                   \
                         "pop r21\n\t"                                                   \
                         "pop r20\n\t"                                                   \
                         "pop r19\n\t"                                                   \
                         "pop r18\n\t"                                                   \
                         "8: pop r31\n\t"                                                \
                         "pop r30\n\t"                                                   \
                         "pop r24\n\t"                                                   \
                         "out __SREG__, r24\n\t"                                         \
                         "pop r24\n\t"                                                   \
                         "cli\n\t"                                                       \
                         "cbi %[flags], %[is_busy]\n\t"                                  \
                         "reti\n\t"                                                      \
                         "9: sbi %[flags], %[one_more]\n\t"                              \
                         "reti\n\t"                                                      \
                         :                                                               \
                         : [flags] "I"(_SFR_IO_ADDR(GPIOR0)),                            \
                           [timer_flags] "I"(_SFR_IO_ADDR(TIFR##timer)),                 \
                           [is_busy] "I"(busy),                                          \
                           [one_more] "I"(overrun),                                      \
                           [size] "n"(CONFIG_CLOCK_EDGES),                               \
                           [cut] "n"(CAPTURE_CUT),                                       \
                           [just_wrapped] "n"(CAPTURE_JUST_WRAPPED_TICKS),               \
                           [edge] "n"(_SFR_MEM_ADDR(ICR##timer)),                        \
                           [count] "n"(_SFR_MEM_ADDR(TCNT##timer)),                      \
                           [top] "n"(_SFR_MEM_ADDR(OCR##timer##A)),                      \
                           [head] "i"(&(queue).head),                                    \
                           [oldest] "i"(&(queue).tail),                                  \
                           [lost] "i"(&(queue).lost),                                    \
                           [entries] "i"((queue).entries),                               \
                           [train_high] "i"(&step_engines[axis].train_high),             \
                           [was_parked] "n"(CAPTURE_WAS_PARKED),                         \
                           [parked] "n"(STEP_STATE_PARKED),                              \
                           [engine_state] "i"(&step_engines[axis].state),                \
                           [engine_tail] "i"(&step_engines[axis].tail),                  \
                           [engine_left] "i"(&step_engines[axis].left),                  \
                           [engine_cut] "i"(&step_engines[axis].cut),                    \
                           [engine_idle] "i"(&step_engines[axis].idle_count));           \
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

// The edge of a parked axis has a period of its own, whatever has begun since.
static inline void capture_place_parked(const struct capture *source,
                                        struct pixel_capture *capture,
                                        uint8_t axis)
{
#if CONFIG_AXES > 1
    if ((source->flags_before & CAPTURE_PARKED) != 0) {
        capture->back = 1;
        capture->sample.idle_count =
            step_isr_idle_count_at(axis, source->idle_count, source->captured);
    }
#else
    (void)source;
    (void)capture;
    (void)axis;
#endif
}

// Take the capture that waits. Returns false when there is none. *capture gets the count, how many
// periods the edge lies back from the one that the engine loaded last, and the sample. busy: the
// source's BUSY bit of GPIOR0; axis: that of the timer. Main loop only, interrupts on.
static inline bool capture_take(struct capture *source,
                                struct pixel_capture *capture,
                                uint8_t axis,
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
    capture_place_parked(source, capture, axis);
    source->waiting = false;
    GPIOR0 &= (uint8_t)~_BV(busy);
    return true;
}
