// SPDX-License-Identifier: MIT
// Runs a fuzzer's target on a stored corpus without the fuzzer: with any compiler, as a test.
//
//     fuzz-replay-NAME CORPUS.hex
//
// The corpus is text: an input is a paragraph of bytes in hexadecimal; '#' begins a comment line.
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "target.h"

#define INPUT_MAX 4096u
#define LINE_MAX  256

static uint8_t input[INPUT_MAX];
static size_t count;
static unsigned played;

static void play(void)
{
    if (count != 0) {
        (void)LLVMFuzzerTestOneInput(input, count);
        played++;
    }
    count = 0;
}

// Value of a hexadecimal digit; -1: none.
static int digit(char character)
{
    static const char digits[] = "0123456789abcdef";
    const char *found = character == '\0' ? NULL : strchr(digits, character);

    return found == NULL ? -1 : (int)(found - digits);
}

// Read the bytes of one row of text; false when it is not a row of bytes.
static int take_line(const char *text)
{
    while (count < INPUT_MAX && digit(text[0]) >= 0 && digit(text[1]) >= 0) {
        input[count] = (uint8_t)(digit(text[0]) * 16 + digit(text[1]));
        count++;
        text += 2;
    }
    return *text == '\n' || *text == '\0';
}

static int play_file(FILE *file, const char *path)
{
    char line[LINE_MAX];
    unsigned number = 0;

    while (fgets(line, sizeof line, file) != NULL) {
        number++;
        if (line[0] == '\n') {
            play();
        } else if (line[0] != '#' && !take_line(line)) {
            (void)fprintf(stderr, "%s:%u: not a row of bytes\n", path, number);
            return 2;
        }
    }
    play();
    (void)printf("%s: %u inputs, no promise broken\n", path, played);
    return played == 0;
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        (void)fputs("usage: fuzz-replay-NAME CORPUS.hex\n", stderr);
        return 2;
    }
    FILE *file = fopen(argv[1], "r");

    if (file == NULL) {
        perror(argv[1]);
        return 2;
    }
    int status = play_file(file, argv[1]);

    (void)fclose(file);
    return status;
}
