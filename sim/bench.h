// SPDX-License-Identifier: MIT
//
// The bench: one to four boards, one serial bus, one pixel clock, one time. Boards run one after
// the other in quanta shorter than the shortest serial frame, so that each receives the
// others' frames in time.
//
//   cycle        0         1000        2000        3000
//   board 0      |--- 1 --->|--- 3 --->|--- 5 --->|        in this order on the PC
//   board 1      |--- 2 --->|--- 4 --->|--- 6 --->|
//   logs                    settled    settled             edges and positions up to here
//
// Everything of one run is in one struct bench. Boards and bus hold pointers into it, so it must
// not move.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "board.h"
#include "bus.h"
#include "edges.h"
#include "pin_flaws.h"
#include "pixel_clock.h"
#include "plant_log.h"
#include "serial_log.h"
#include "vcd.h"
#include "wire_log.h"

struct bench {
    struct board board[BUS_BOARDS];
    int boards; // of them that are open
    struct bus bus;
    struct pixel_clock clock;
    struct pin_flaws pin[BUS_BOARDS]; // of the clock's pin, by board
    struct edges edges;
    struct serial_log serial_log; // of the first board
    struct plant_log plant_log;
    FILE *switch_log;         // NULL for none
    FILE *pin_log;            // of the clock's edges at each pin; NULL for none
    struct wire_log wire_log; // of the first board
    struct vcd vcd;
    bool has_vcd;                        // vcd is open
    const char *eeprom_path[BUS_BOARDS]; // NULL for none
    uint64_t cycle;                      // every board has reached it
    double wall_started_s;               // bench_wall_s() at the start of the run
};

// Runs everything up to this cycle. False when a board has stopped (its error says why, or it is
// done); the others stand at the end of that quantum.
bool bench_run(struct bench *bench, uint64_t cycle);

// The longest step that bench_run may be asked for when someone watches the bus: this many cycles
// after its start, every frame has reached all receivers.
uint32_t bench_quantum(const struct bench *bench);

// All boards are without power until a cycle of their own within the first `cycles`, at random by
// this seed. Call before the run, once the boards are open.
void bench_power_up(struct bench *bench, uint64_t cycles, uint64_t seed);

// Writes a board's EEPROM into its file, if it has one. False with errno set.
bool bench_save_eeprom(const struct bench *bench, int board);

// The first error of a board, NULL if none has one.
const char *bench_error(const struct bench *bench);

// Seconds of a steady clock.
double bench_wall_s(void);
