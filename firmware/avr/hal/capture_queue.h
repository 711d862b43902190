// SPDX-License-Identifier: MIT
// Edges of the pixel clock that wait for the main loop: what the capture interrupt
// (pixel_clock_isr.S) and pixel_clock.c share.
#pragma once

#include <stdint.h>

#include "config.h"             // CONFIG_AXES, CONFIG_CLOCK_EDGES
#include "ring/captured_edge.h" // struct captured_edge

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

_Static_assert((CONFIG_CLOCK_EDGES & (CONFIG_CLOCK_EDGES - 1u)) == 0 &&
                   CONFIG_CLOCK_EDGES <= 16u,
               "pixel_clock_isr.S masks the queue's index and shifts it by four bits");

// The edges; pixel_clock.c has them.
extern struct capture_queue pixel_clock_edges;
