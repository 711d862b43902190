// SPDX-License-Identifier: MIT
//
// The run loop in the place of simavr's, which (1.6) wrongly
//  * lets two instructions pass after SEI and RETI before an interrupt; the part lets one,
//  * oversleeps every event by one cycle, and really sleeps on the PC,
//  * does not shorten its run up to the next event by the cycles of an interrupt's response,
//  * spends a whole instruction's chance of service on each flag cleared while it waited.
#pragma once

#include <sim_avr.h>

// One stretch of instructions up to the next event, the event, and an interrupt if one is due.
void board_slice(avr_t *avr);

struct board;

// What the board does next: run its program, hang, or stand without power. It takes the place of
// simavr's avr->run.
avr_run_t board_next_run(const struct board *board);

// Does what board_want has asked for (board_reset.c).
void board_do_wanted(avr_t *avr);

// Tells simavr when the quantum ends: a sleep must not last beyond it.
void board_schedule_end(struct board *board);
