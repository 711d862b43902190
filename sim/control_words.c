// SPDX-License-Identifier: MIT

#include "control_words.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void control_answer(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    (void)vprintf(format, arguments);
    va_end(arguments);
    (void)putchar('\n');
}

void control_answer_hex(const char *kind, const uint8_t *bytes, size_t count)
{
    (void)printf("%s ", kind);
    for (size_t i = 0; i < count; i++) {
        (void)printf("%02x", bytes[i]);
    }
    if (count == 0) {
        (void)putchar('-');
    }
}

bool control_number(const char *text, uint64_t most, uint64_t *value)
{
    char *end;

    *value = strtoull(text, &end, 0);
    if (text[0] == '-' || end == text || *end != '\0' || *value > most) {
        control_answer("error '%s' is not a number from 0 to %" PRIu64, text, most);
        return false;
    }
    return true;
}

bool control_bytes(struct control *c, const char *text, size_t *count)
{
    size_t length = strlen(text);

    if (length == 0 || length % 2 != 0 || length / 2 > CONTROL_BYTES_MAX ||
        strspn(text, "0123456789abcdefABCDEF") != length) {
        control_answer("error '%.40s' is not a row of bytes in hexadecimal", text);
        return false;
    }
    *count = length / 2;
    for (size_t i = 0; i < *count; i++) {
        char digits[3] = {text[2 * i], text[2 * i + 1], '\0'};

        c->bytes[i] = (uint8_t)strtoul(digits, NULL, 16);
    }
    return true;
}

struct board *control_board(struct control *c)
{
    uint64_t index;

    if (!control_number(c->word[1], (uint64_t)c->bench->boards - 1, &index)) {
        return NULL;
    }
    return &c->bench->board[index];
}

bool control_board_axis(struct control *c, struct board **board, unsigned *axis)
{
    uint64_t index;

    *board = control_board(c);
    if (*board == NULL ||
        !control_number(c->word[2], (uint64_t)(*board)->kind->axes - 1, &index)) {
        return false;
    }
    *axis = (unsigned)index;
    return true;
}

bool control_at(struct control *c, int first, bool *later, uint64_t *cycle)
{
    *later = c->words > first;
    *cycle = c->bench->cycle;
    if (!*later) {
        return true;
    }
    if (c->words != first + 2 || strcmp(c->word[first], "at") != 0) {
        control_answer(
            "error %s: expected 'at CYCLE' after '%s'", c->word[0], c->word[first - 1]);
        return false;
    }
    if (!control_number(c->word[first + 1], UINT64_MAX / 2, cycle)) {
        return false;
    }
    if (*cycle < c->bench->cycle) {
        control_answer("error %s: cycle %" PRIu64 " is over, it is %" PRIu64,
                       c->word[0],
                       *cycle,
                       c->bench->cycle);
        return false;
    }
    return true;
}
