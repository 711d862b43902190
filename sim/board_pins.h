// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.
//
// Which signal of a board is on which pin: the same tables that the firmware is built from.
#pragma once

#include <stddef.h>
#include <stdint.h>

#define BOARD_KIND_AXES 4 // of the board that has most
#define BOARD_AXES      BOARD_KIND_AXES

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
    int axes;
    char axis_timer[BOARD_KIND_AXES]; // '1' for timer 1
    const struct board_pin *pins;
    size_t pin_count;
};

// NULL if there is no such board.
const struct board_kind *board_kind_by_name(const char *name);

// Names of all boards, for messages.
const char *board_kind_names(void);

// The pin of a signal, NULL if the board has none.
const struct board_pin *board_kind_pin(const struct board_kind *kind,
                                       enum board_signal signal,
                                       unsigned axis);
