// SPDX-License-Identifier: MIT
//
// What the commands of the control protocol (control.h) share: the words of a command, its answer,
// and how words are read.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bench.h"
#include "pty.h"

#define CONTROL_WORDS_MAX 9
#define CONTROL_BYTES_MAX (1U << 16)

// One session.
struct control {
    struct bench *bench;
    struct pty pty; // the bus as a pseudo terminal, if a command has opened it
    char *word
        [CONTROL_WORDS_MAX]; // of the present command; a command may change their text
    int words;
    uint8_t *bytes; // room for CONTROL_BYTES_MAX of them
    bool quit;      // the session ends after this command
};

// One command of the protocol.
struct command {
    const char *name;
    int words_min, words_max; // the name is one of them
    void (*execute)(struct control *c);
};

// Prints the line that answers a command, with its line end.
__attribute__((format(printf, 1, 2))) void control_answer(const char *format, ...);

// Prints the beginning of such a line: a word, and bytes in hexadecimal ("-" for none).
void control_answer_hex(const char *kind, const uint8_t *bytes, size_t count);

// The following functions answer with an error, and return false or NULL, if a word is wrong.

// Reads a word as a number from 0 to `most`.
bool control_number(const char *text, uint64_t most, uint64_t *value);

// Reads a word as bytes in hexadecimal, into c->bytes.
bool control_bytes(struct control *c, const char *text, size_t *count);

// The board that the second word names.
struct board *control_board(struct control *c);

// The board and axis that the second and third word name.
bool control_board_axis(struct control *c, struct board **board, unsigned *axis);

// Reads the words from `first` on as "at CYCLE": sets *later, and *cycle to a cycle that is not
// over. Without such words *later is false and *cycle is now.
bool control_at(struct control *c, int first, bool *later, uint64_t *cycle);
