// SPDX-License-Identifier: MIT
//
// What the control protocol's commands share: the words of a line, and its answer.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "bench.h"

#define CONTROL_WORDS_MAX 9
#define CONTROL_BYTES_MAX (1U << 16)

struct control {
    struct bench *bench;
    char *word[CONTROL_WORDS_MAX];
    int words;
    uint8_t *bytes; // CONTROL_BYTES_MAX of them
    bool quit;
};

struct command {
    const char *name;
    int words_min, words_max; // with the name
    void (*execute)(struct control *c);
};

// The line that answers a command.
__attribute__((format(printf, 1, 2))) void control_answer(const char *format, ...);

// The first part of such a line: a word and bytes in hexadecimal.
void control_answer_hex(const char *kind, const uint8_t *bytes, size_t count);

// These return false, or NULL, after an error's answer.

// A word as a number from 0 to `most`.
bool control_number(const char *text, uint64_t most, uint64_t *value);

// A word as bytes, into c->bytes.
bool control_bytes(struct control *c, const char *text, size_t *count);

// The board of the second word.
struct board *control_board(struct control *c);

// The board and axis of the second and third word.
bool control_board_axis(struct control *c, struct board **board, unsigned *axis);

// The words from this one on, if there are any, as "at CYCLE": a cycle that is not over. Without
// them *planned is false.
bool control_at(struct control *c, int first, bool *planned, uint64_t *cycle);
