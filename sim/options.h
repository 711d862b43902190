// SPDX-License-Identifier: MIT
//
// The command line.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "board_pins.h"
#include "bus.h"
#include "pixel_clock.h"
#include "plant.h"

enum run_mode { MODE_NONE, MODE_CONTROL, MODE_PTY, MODE_RUN_MS, MODE_UNIT };

struct options {
    int boards;
    char *board_name[BUS_BOARDS];
    char *board_image[BUS_BOARDS];
    const char *eeprom_path[BUS_BOARDS]; // NULL for none
    struct plant_settings plant[BUS_BOARDS][BOARD_AXES];
    struct pixel_clock_settings clock;
    const char *edges_path, *clock_log_path, *serial_log_path, *plant_log_path,
        *switch_log_path, *wire_log_path, *vcd_path;
    enum run_mode mode;
    uint64_t run_ms, unit_limit_ms;
    bool stats; // print the statistics at the end of --run-ms
};

// Reads the command line. On an error prints one line and exits with status 2; --help prints the
// manual and exits with status 0. Changes the arguments' text.
void options_read(struct options *options, int argc, char **argv);
