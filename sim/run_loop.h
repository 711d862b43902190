// SPDX-License-Identifier: MIT
//
// The loop that executes a board's program, in the place of simavr's, which (1.6) wrongly
//  * lets two instructions pass after SEI and RETI before an interrupt; the part lets one,
//  * oversleeps every event by one cycle, and really sleeps on the PC,
//  * does not shorten its run up to the next event by the cycles of an interrupt's response,
//  * spends a whole instruction's chance of service on each flag cleared while it waited.
//
// What the loop executes is one of these states; the board chooses it:
//
//   RUN_PROGRAM      the program
//   RUN_MAIN_HUNG    interrupt handlers; the main program jumps to itself
//   RUN_ALL_HUNG     nothing: a loop with interrupts off
//   RUN_UNPOWERED    nothing; events outside the part go on
//   RUN_REQUESTED    the hook `requested`, once, before any further instruction
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include <sim_avr.h>

#include "irq_stats.h"
#include "plain.h"
#include "skips.h"

enum run_state {
    RUN_PROGRAM,
    RUN_MAIN_HUNG,
    RUN_ALL_HUNG,
    RUN_UNPOWERED,
    RUN_REQUESTED,
};

struct run_loop_hooks {
    void *board;
    // An interrupt has been served: models whose interrupts are levels look at them again.
    void (*served)(void *board);
    // Performs what waited for the end of an instruction; chooses another state than RUN_REQUESTED.
    void (*requested)(void *board);
};

// What is known of the image's instructions.
struct run_loop_image {
    const struct plain_program *program;
    const struct skips *skips;
};

struct run_loop {
    avr_t *avr;
    struct irq_stats *stats;
    struct run_loop_image image;
    const struct run_loop_hooks *hooks;
    enum run_state state;  // the board sets it
    uint64_t end;          // of the present call of run_loop_run
    uint64_t sleep_cycles; // so far, in all
};

// Connects the loop. Call once the part exists. All pointers must stay valid.
void run_loop_attach(struct run_loop *loop,
                     avr_t *avr,
                     struct irq_stats *stats,
                     const struct run_loop_image *image,
                     const struct run_loop_hooks *hooks);

// Executes until the part has reached this cycle (it may pass it by the rest of an instruction) or
// has stopped. True while the part can go on.
bool run_loop_run(struct run_loop *loop, uint64_t cycle);

// From where interrupts are on the processor stands still for so many cycles; timers and the world
// go on. Call between two runs.
void run_loop_stall(struct run_loop *loop, uint64_t cycles);

// Ends the present instruction without serving an interrupt after it, and a sleep at once; the
// state becomes RUN_REQUESTED. May be called from within an instruction or event.
void run_loop_request(struct run_loop *loop);

// Schedules the end of the present call of run_loop_run: a sleep must not last beyond it. Call
// after a reset, which empties libsimavr's list of events.
void run_loop_schedule(struct run_loop *loop);
