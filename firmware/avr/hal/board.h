// SPDX-License-Identifier: MIT
// Rows of the board file (BOARD_FILE) by signal. A reader names the signals that it wants and keeps
// their rows; all other rows expand to nothing:
//
//     #define WANT_DIR BOARD_WANTED
//     #define BOARD_PIN(signal, axis, port, bit, header_pin)
//         BOARD_KEEP(WANT_##signal)(WRITE_CASE(axis, port, bit))
//     #include BOARD_FILE
//     #undef WANT_DIR
//
// The preprocessor does all of it, so that a row that is dropped costs nothing. The macros below
// work by counting: BOARD_WANTED carries a comma, which moves BOARD_ROW_KEPT to the second place; a
// signal without a definition leaves BOARD_ROW_LEFT_OUT there.
#pragma once

#include "config.h" // BOARD_...

#define BOARD_WANTED            ~, BOARD_ROW_KEPT
#define BOARD_KEEP(...)         BOARD_SECOND(__VA_ARGS__, BOARD_ROW_LEFT_OUT, ~)
#define BOARD_SECOND(a, b, ...) b
#define BOARD_ROW_KEPT(...)     __VA_ARGS__
#define BOARD_ROW_LEFT_OUT(...)
