// SPDX-License-Identifier: MIT
//
// One simulated board, put together from its parts: the microcontroller with our models of its
// peripherals, its pins wired to the signals of firmware/avr/boards/<name>.def, its axes'
// mechanics. Each part keeps its own state behind its own header; this module alone knows how they
// are wired:
//
//                    +-- switches <-- plant, contact <-+
//                    v                  (mechanics)    | steps
//   pixel_input --> inputs --> timers, comparator,   outputs --> edges
//   schedule -----^            extint                  ^   |
//      |                          |                    |   +--> uart --> bus
//      v                          v     compare output |
//   supply --> run_loop --> the program --> ports -----+
//                 ^
//                hang
//
// The bench and the control protocol call these functions between two calls of board_run(). They
// ask the parts directly for everything that concerns one part only.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include <sim_avr.h>

#include "board_pins.h"
#include "bus.h"
#include "comparator.h"
#include "edges.h"
#include "eeprom.h"
#include "extint.h"
#include "hang.h"
#include "inputs.h"
#include "irq_stats.h"
#include "mechanics.h"
#include "outputs.h"
#include "own_time.h"
#include "pixel_input.h"
#include "plant_log.h"
#include "ports.h"
#include "run_loop.h"
#include "schedule.h"
#include "serial_log.h"
#include "skips.h"
#include "stack.h"
#include "supply.h"
#include "switches.h"
#include "symbols.h"
#include "timer0.h"
#include "timers.h"
#include "uart.h"
#include "watchdog.h"
#include "wire_log.h"

#define BOARD_ERROR 256

// Where a board writes what happens; NULL for no such log.
struct board_logs {
    struct edges *edges; // never NULL
    struct serial_log *serial;
    struct plant_log *plant;
    struct wire_log *wire;
    FILE *switches;
};

// How the parts call each other through their board.
struct board_wiring {
    struct peripheral_host host;
    struct ports_hooks ports;
    struct timer16_hooks timers;
    struct timer0_hooks timer0;
    struct outputs_hooks outputs;
    struct comparator_hooks comparator;
    struct uart_hooks uart;
    struct watchdog_hooks watchdog;
    struct supply_hooks supply;
    struct run_loop_hooks run_loop;
};

struct board {
    // What every instruction needs.
    avr_t *avr;
    struct run_loop run_loop;
    struct irq_stats stats;
    struct plain_program program; // of the image, as are:
    struct skips skips;

    // What events need.
    struct timers timers;
    struct timer0 timer0;
    struct ports ports;
    struct inputs inputs;
    struct outputs outputs;
    struct comparator comparator;
    struct extint extint;
    struct uart uart;
    struct mechanics mechanics;
    struct switches switches;
    struct pixel_input pixel_input;

    // What is rarely looked at.
    int index; // on the bench
    struct own_time time;
    const struct board_kind *kind;
    avr_io_t module; // the board itself among libsimavr's modules: resets, WDR
    void (*init_part)(avr_t *avr);
    struct bus *bus;
    struct serial_log *serial_log; // NULL for none
    struct board_wiring wiring;
    struct eeprom eeprom;
    struct watchdog watchdog;
    struct supply supply;
    struct schedule schedule;
    struct hang hang;
    struct stack_watch stack;
    struct board *clock_wire[BUS_BOARDS]; // whose pixel clock this board makes
    int clock_wires;
    bool clock_is_wired;     // a board makes this one's pixel clock
    struct symbols symbols;  // of the image
    uint8_t strap;           // GPIOR2 after a reset
    char error[BOARD_ERROR]; // not empty: the board has stopped for this reason
};

// Makes the board number `index` of the bench, loads an image into it and connects it to the bus.
// Its oscillator is off by so many ppm; that of board 0 is the bench's time.
// The board must stay where it is in memory. On failure returns false with one line in
// board->error.
bool board_open(struct board *board,
                int index,
                const char *kind_name,
                const char *image_path,
                double oscillator_ppm,
                struct bus *bus,
                const struct board_logs *logs);

// Wires CLOCK_OUT of a board to PIXEL_CLOCK of itself, or of a board that runs after it in each
// quantum. Call once for each of the two.
void board_wire_clock(struct board *from, struct board *to);

// The bench's cycle that the board has reached.
uint64_t board_bench_cycle(const struct board *board);

// Runs until the board has reached this cycle of the bench (it may pass it by the rest of an
// instruction), or has stopped. True while it goes on.
bool board_run(struct board *board, uint64_t cycle);

// The program has ended by itself: sleep with interrupts off.
bool board_is_done(const struct board *board);

// Stops the board with this one-line reason. The first reason counts.
void board_refuse(struct board *board, const char *text);

// Seeds the noise of memories: after a power cut they hold another stretch of it each time.
void board_seed(struct board *board, uint64_t seed);

// Faults, which end with board_end_hang() or a reset (hang.h). This one: the main program stands
// still where it is when interrupts are next on; interrupts are served.
void board_hang_main(struct board *board);

// The part loops with interrupts off.
void board_hang_interrupts(struct board *board);

// The processor stands still for so many cycles, so that every interrupt comes later.
void board_stall(struct board *board, uint64_t cycles);

// An axis's step interrupt returns at its vector. False if there are too many patches.
bool board_hang_axis(struct board *board, unsigned axis);

// Ends all faults, the kept ones too, and restores the image.
void board_end_hang(struct board *board);

// Frees what the board holds. Safe after a failed board_open().
void board_close(struct board *board);
