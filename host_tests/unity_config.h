// SPDX-License-Identifier: MIT
// How Unity is built here: no floats (3 KB of flash instead of 10), 64-bit integers, and text that
// leaves by a character function of our own on the simulated board.
#pragma once

#define UNITY_EXCLUDE_FLOAT
#define UNITY_EXCLUDE_DOUBLE
#define UNITY_SUPPORT_64

#ifdef __AVR__
// From on_avr.c: one character to UART 0.
void board_put_char(int character);

#define UNITY_OUTPUT_CHAR(character) board_put_char(character)

// Names would stand in RAM, of which the machine's suites leave hardly any: a test is known by its
// line.
void board_run_test(void (*test)(void), int line);
#define RUN_TEST(test) board_run_test((test), __LINE__)

// The suite's own main under the name that the build gives it there.
int suite_main(void);
#endif
