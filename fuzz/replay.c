// SPDX-License-Identifier: MIT
// Plays a kept corpus through a fuzzer's target without the fuzzer: with any compiler, as a test.
//
//     fuzz-replay-NAME CORPUS.hex
//
// The corpus is text: an input is a paragraph of bytes in hexadecimal; '#' begins a comment line.
#include <ctype.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define INPUT_MAX 4096u
#define LINE_MAX  256

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

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

// The bytes of one line; false when it is not a row of bytes.
static int take_line(const char *text)
{
    while (isxdigit((unsigned char)text[0]) && isxdigit((unsigned char)text[1]) &&
           count < INPUT_MAX) {
        const char digits[3] = {text[0], text[1], '\0'};

        input[count] = (uint8_t)strtoul(digits, NULL, 16);
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
