// SPDX-License-Identifier: MIT
//
// The command line: the boards of a run, their mechanics, the pixel clock, the output files and
// what to do. --help describes every option.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "board_pins.h"
#include "bus.h"
#include "pixel_clock.h"
#include "plant.h"

// What the program does with the boards.
enum run_mode { MODE_NONE, MODE_CONTROL, MODE_PTY, MODE_RUN_MS, MODE_UNIT };

struct options {
    int boards; // given so far; board i answers as unit i + 1
    char *board_name[BUS_BOARDS];
    char *board_image[BUS_BOARDS];
    const char *eeprom_path[BUS_BOARDS]; // NULL for none
    double oscillator_ppm[BUS_BOARDS];   // of the first board always 0
    int clock_from
        [BUS_BOARDS]; // the board whose clock each gets, counted from 1; 0: the bench's
    // Mechanics of each axis; `present` is false where none was given.
    struct plant_settings plant[BUS_BOARDS][BOARD_AXES];
    struct pixel_clock_settings clock;
    uint64_t power_up_ms; // within which each board gets its supply; 0: all at the start
    // Output files, NULL for none.
    const char *edges_path, *clock_log_path, *pin_log_path, *serial_log_path,
        *plant_log_path, *switch_log_path, *wire_log_path, *vcd_path;
    enum run_mode mode;
    uint64_t run_ms;        // with MODE_RUN_MS: simulated time
    uint64_t unit_limit_ms; // with MODE_UNIT: simulated time at most
    bool stats;             // print the statistics at the end of --run-ms
};

// Reads the command line. On an error prints one line and exits with status 2; --help prints the
// manual and exits with status 0. Changes the arguments' text.
void options_read(struct options *options, int argc, char **argv);
