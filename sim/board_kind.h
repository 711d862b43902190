// SPDX-License-Identifier: MIT
//
// What the simulator knows about a kind of board: the contents of its board file.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define BOARD_KIND_AXES 4 // of the board that has most

enum board_signal {
    SIGNAL_STEP,
    SIGNAL_DIR,
    SIGNAL_ENABLE,
    SIGNAL_HOME,
    SIGNAL_LIMIT_MINUS,
    SIGNAL_LIMIT_PLUS,
    SIGNAL_PIXEL_CLOCK,
    SIGNAL_PIXEL_CLOCK_COPY,
    SIGNAL_ESTOP,
    SIGNAL_RS485_DE,
    SIGNAL_PERMIT,
    SIGNAL_CLOCK_OUT,
    SIGNAL_ENCODER_A,
    SIGNAL_ENCODER_B,
};

struct board_pin {
    enum board_signal signal;
    uint8_t axis;
    char port;
    uint8_t bit;
};

struct board_kind {
    const char *name; // as on the command line
    const char *mcu;  // as simavr knows it
    uint32_t cpu_hz;
    int axes;
    char axis_timer[BOARD_KIND_AXES]; // '1' for timer 1
    bool clock_out_is_oc0b;           // else the program makes its edges
    const struct board_pin *pins;
    size_t pin_count;
};
