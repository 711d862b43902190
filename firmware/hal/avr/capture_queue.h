// SPDX-License-Identifier: MIT
// Edges of the pixel clock that wait for the main loop: what the capture interrupt
// (pixel_clock_isr.S) and pixel_clock.c share. Included by both.
#pragma once

#include "config.h"               // CONFIG_AXES, CONFIG_CLOCK_EDGES
#include "motion/captured_edge.h" // struct captured_edge

// Of struct capture_queue; from CAPTURE_FIRST_COUNTER on with several axes only.
#define CAPTURE_QUEUE_HEAD     0
#define CAPTURE_QUEUE_TAIL     1
#define CAPTURE_QUEUE_LOST     2
#define CAPTURE_FIRST_LEFT     3
#define CAPTURE_FIRST_TAIL     4
#define CAPTURE_FIRST_IDLE_LOW 5
#define CAPTURE_FIRST_COUNTER  6
#define CAPTURE_FIRST_UNIT     8
#if CONFIG_AXES > 1
#define CAPTURE_QUEUE_ENTRIES 9
#else
#define CAPTURE_QUEUE_ENTRIES 6
#endif

#if !defined(__ASSEMBLER__)
#include <stddef.h> // offsetof
#include <stdint.h>

// Edges that wait for the main loop. Both ends run freely.
struct capture_queue {
    volatile uint8_t head; // only the handler writes it
    volatile uint8_t tail; // only the main loop writes it
    // Edges that found the queue full; stays at 255. The main loop clears it.
    volatile uint8_t lost;
    // What the handler notes before it lets other interrupts in: struct engine_sample,
    int8_t first_left;
    uint8_t first_tail;
    uint8_t first_idle_low;
#if CONFIG_AXES > 1
    // if the timer's overflow flag is set (FLAG_PIXEL_CLOCK_WRAPPED) the timer's count,
    uint16_t first_counter;
    // or, of a parked axis, timer 0's: the low byte of the coarse clock's units.
    uint8_t first_unit;
#endif
    struct captured_edge entries[CONFIG_CLOCK_EDGES];
};

_Static_assert(
    sizeof(struct captured_edge) == CAPTURED_EDGE_SIZE &&
        offsetof(struct captured_edge, ticks) == CAPTURED_EDGE_TICKS &&
        offsetof(struct captured_edge, tail) == CAPTURED_EDGE_TAIL &&
        offsetof(struct captured_edge, left_or_cut) == CAPTURED_EDGE_LEFT_OR_CUT &&
        offsetof(struct captured_edge, idle_count) == CAPTURED_EDGE_IDLE_COUNT &&
        offsetof(struct captured_edge, notes) == CAPTURED_EDGE_NOTES &&
        offsetof(struct capture_queue, head) == CAPTURE_QUEUE_HEAD &&
        offsetof(struct capture_queue, tail) == CAPTURE_QUEUE_TAIL &&
        offsetof(struct capture_queue, lost) == CAPTURE_QUEUE_LOST &&
        offsetof(struct capture_queue, first_left) == CAPTURE_FIRST_LEFT &&
        offsetof(struct capture_queue, first_tail) == CAPTURE_FIRST_TAIL &&
        offsetof(struct capture_queue, first_idle_low) == CAPTURE_FIRST_IDLE_LOW &&
        offsetof(struct capture_queue, entries) == CAPTURE_QUEUE_ENTRIES,
    "known to pixel_clock_isr.S");
#if CONFIG_AXES > 1
_Static_assert(offsetof(struct capture_queue, first_counter) == CAPTURE_FIRST_COUNTER &&
                   offsetof(struct capture_queue, first_unit) == CAPTURE_FIRST_UNIT,
               "known to pixel_clock_isr.S");
#endif
_Static_assert((CONFIG_CLOCK_EDGES & (CONFIG_CLOCK_EDGES - 1u)) == 0 &&
                   CONFIG_CLOCK_EDGES <= 16u,
               "pixel_clock_isr.S masks the queue's index and shifts it by four bits");

// The edges; pixel_clock.c has them.
extern struct capture_queue pixel_clock_edges;
#endif
