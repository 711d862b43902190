// SPDX-License-Identifier: MIT
// This file is MIT; the program it is linked into is GPL-3.0 as a whole, because of libsimavr.

#include "control.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "exchange.h"
#include "stats.h"

#define WORDS_MAX      6
#define BYTES_MAX      (1U << 16)
#define TIMEOUT_CYCLES 1600000U // 100 ms
#define PPM_LIMIT      1e5

struct control {
    struct bench *bench;
    char *word[WORDS_MAX];
    int words;
    uint8_t *bytes;
    bool quit;
};

struct command {
    const char *name;
    int words_min, words_max; // with the name
    void (*run)(struct control *c);
};

__attribute__((format(printf, 1, 2))) static void answer(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    (void)vprintf(format, arguments);
    va_end(arguments);
    (void)putchar('\n');
}

static void answer_hex(const char *kind, const uint8_t *bytes, size_t count)
{
    (void)printf("%s ", kind);
    for (size_t i = 0; i < count; i++) {
        (void)printf("%02x", bytes[i]);
    }
    if (count == 0) {
        (void)putchar('-');
    }
}

static bool number(const char *text, uint64_t most, uint64_t *value)
{
    char *end;

    *value = strtoull(text, &end, 0);
    if (text[0] == '-' || end == text || *end != '\0' || *value > most) {
        answer("error '%s' is not a number from 0 to %" PRIu64, text, most);
        return false;
    }
    return true;
}

static bool hex_bytes(struct control *c, const char *text, size_t *count)
{
    size_t length = strlen(text);

    if (length == 0 || length % 2 != 0 || length / 2 > BYTES_MAX ||
        strspn(text, "0123456789abcdefABCDEF") != length) {
        answer("error '%.40s' is not a row of bytes in hexadecimal", text);
        return false;
    }
    *count = length / 2;
    for (size_t i = 0; i < *count; i++) {
        char digits[3] = {text[2 * i], text[2 * i + 1], '\0'};

        c->bytes[i] = (uint8_t)strtoul(digits, NULL, 16);
    }
    return true;
}

static struct board *board_of(struct control *c)
{
    uint64_t index;

    if (!number(c->word[1], (uint64_t)c->bench->boards - 1, &index)) {
        return NULL;
    }
    return &c->bench->board[index];
}

// The board and axis of the second and third word; false after an error's answer.
static bool board_and_axis(struct control *c, struct board **board, unsigned *axis)
{
    uint64_t index;

    *board = board_of(c);
    if (*board == NULL ||
        !number(c->word[2], (uint64_t)(*board)->kind->axes - 1, &index)) {
        return false;
    }
    *axis = (unsigned)index;
    return true;
}

static struct board_axis *axis_of(struct control *c)
{
    struct board *board;
    unsigned axis;

    return board_and_axis(c, &board, &axis) ? &board->axis[axis] : NULL;
}

static void answer_stopped(const struct control *c)
{
    const char *error = bench_error(c->bench);

    answer("error %s", (error != NULL) ? error : "a board's program has ended");
}

static void do_run(struct control *c)
{
    uint64_t cycles;

    if (!number(c->word[1], UINT64_MAX / 2, &cycles)) {
        return;
    }
    if (bench_run(c->bench, c->bench->cycle + cycles)) {
        answer("ok %" PRIu64, c->bench->cycle);
    } else {
        answer_stopped(c);
    }
}

static void do_tx(struct control *c)
{
    uint64_t timeout = TIMEOUT_CYCLES;
    size_t count;
    size_t received;

    if (!hex_bytes(c, c->word[1], &count) ||
        (c->words > 2 && !number(c->word[2], UINT64_MAX / 2, &timeout))) {
        return;
    }
    if (exchange(c->bench, c->bytes, count, timeout, c->bytes, BYTES_MAX, &received)) {
        answer_hex("rx", c->bytes, received);
        answer(" %" PRIu64, c->bench->cycle);
    } else {
        answer_stopped(c);
    }
}

static bool set_ppm(struct pixel_clock *clock, const char *value)
{
    char *end;
    double ppm = strtod(value, &end);

    if (end == value || *end != '\0' || !(ppm > -PPM_LIMIT && ppm < PPM_LIMIT)) {
        answer("error '%s' is not a frequency error in ppm", value);
        return false;
    }
    pixel_clock_set_ppm(clock, ppm);
    return true;
}

static void do_clock(struct control *c)
{
    struct pixel_clock *clock = &c->bench->clock;
    const char *what = c->word[1];
    const char *value = (c->words > 2) ? c->word[2] : "";
    bool done = true;

    if (strcmp(what, "on") == 0 || strcmp(what, "off") == 0) {
        clock->on = strcmp(what, "on") == 0;
    } else if (strcmp(what, "drop") == 0) {
        done = number(value, UINT64_MAX / 2, &clock->drop);
    } else if (strcmp(what, "ppm") == 0) {
        done = set_ppm(clock, value);
    } else {
        answer("error clock '%s': on, off, drop N or ppm X", what);
        done = false;
    }
    if (done) {
        answer("ok");
    }
}

static void do_steps(struct control *c)
{
    const struct board_axis *axis = axis_of(c);

    if (axis != NULL) {
        answer("steps %" PRId64 " %" PRIu64, axis->steps_signed, c->bench->cycle);
    }
}

static void do_counts(struct control *c)
{
    const struct board_axis *axis = axis_of(c);

    if (axis != NULL) {
        answer("counts %" PRIu64, axis->steps_rising);
    }
}

static void do_plant(struct control *c)
{
    const struct board_axis *axis = axis_of(c);

    if (axis != NULL) {
        answer("plant %" PRId64 " %" PRId64, axis->plant.motor, axis->plant.load);
    }
}

static void do_knobs(struct control *c)
{
    struct board *board;
    unsigned axis;
    struct plant_settings settings;
    char error[128];

    if (!board_and_axis(c, &board, &axis)) {
        return;
    }
    settings = board->axis[axis].plant.settings;
    settings.has_start = settings.has_seed = false; // only if named now
    if (plant_parse(&settings, c->word[3], error, sizeof error)) {
        board_change_plant(board, axis, &settings);
        answer("ok");
    } else {
        answer("error knobs: %s", error);
    }
}

static void do_switches(struct control *c)
{
    struct board *board;
    unsigned axis;
    const struct board_switch *log;

    if (!board_and_axis(c, &board, &axis)) {
        return;
    }
    log = board->axis[axis].switches;
    (void)fputs("switches", stdout);
    for (unsigned i = 0; i < PLANT_SWITCHES; i++) {
        (void)printf(
            " %" PRIu64 " %d", log[i].cycle, board_switch_level(board, axis, i) ? 1 : 0);
    }
    answer(" %" PRIu64, log[PLANT_HOME].first_cycle);
}

static void do_peek(struct control *c)
{
    struct board *board = board_of(c);
    uint64_t address;
    uint64_t count;

    if (board != NULL && number(c->word[2], board->avr->ramend, &address) &&
        number(c->word[3], board->avr->ramend + 1U - address, &count)) {
        answer_hex("mem", &board->avr->data[address], (size_t)count);
        answer("%s", "");
    }
}

static void do_poke(struct control *c)
{
    struct board *board = board_of(c);
    uint64_t address;
    size_t count;

    if (board == NULL || !number(c->word[2], board->avr->ramend, &address) ||
        !hex_bytes(c, c->word[3], &count)) {
        return;
    }
    if (address + count > board->avr->ramend + 1U) {
        answer("error %zu bytes at %" PRIu64 " go beyond the RAM's end", count, address);
        return;
    }
    memcpy(&board->avr->data[address], c->bytes, count);
    answer("ok");
}

static void do_pin(struct control *c)
{
    struct board *board = board_of(c);
    uint64_t bit;
    uint64_t level;

    if (board == NULL || !number(c->word[3], 7, &bit) || !number(c->word[4], 1, &level)) {
        return;
    }
    if (strlen(c->word[2]) != 1 || c->word[2][0] < 'A' || c->word[2][0] > 'L') {
        answer("error '%s' is not a port from A to L", c->word[2]);
        return;
    }
    board_drive_pin(board, c->word[2][0], (unsigned)bit, level != 0, c->bench->cycle);
    answer("ok");
}

static void do_stats(struct control *c)
{
    stats_write(stdout, c->bench);
    answer("%s", "");
}

static void do_mark(struct control *c)
{
    for (int i = 0; i < c->bench->boards; i++) {
        irq_stats_mark(&c->bench->board[i].stats);
    }
    answer("ok %" PRIu64, c->bench->cycle);
}

static void do_flush(struct control *c)
{
    edges_flush(&c->bench->edges);
    serial_log_flush(&c->bench->serial_log);
    plant_log_flush(&c->bench->plant_log);
    if (c->bench->switch_log != NULL) {
        (void)fflush(c->bench->switch_log);
    }
    if (c->bench->clock.log != NULL) {
        (void)fflush(c->bench->clock.log);
    }
    answer("ok");
}

static void do_quit(struct control *c)
{
    c->quit = true;
    answer("ok");
}

static const struct command commands[] = {
    {"run", 2, 2, do_run},
    {"tx", 2, 3, do_tx},
    {"clock", 2, 3, do_clock},
    {"steps", 3, 3, do_steps},
    {"counts", 3, 3, do_counts},
    {"plant", 3, 3, do_plant},
    {"knobs", 4, 4, do_knobs},
    {"switches", 3, 3, do_switches},
    {"peek", 4, 4, do_peek},
    {"poke", 4, 4, do_poke},
    {"pin", 5, 5, do_pin},
    {"stats", 1, 1, do_stats},
    {"mark", 1, 1, do_mark},
    {"flush", 1, 1, do_flush},
    {"quit", 1, 1, do_quit},
};

static void split(struct control *c, char *line)
{
    char *rest = line;
    char *word;

    c->words = 0;
    while ((word = strsep(&rest, " \t\r\n")) != NULL && c->words < WORDS_MAX) {
        if (word[0] != '\0') {
            c->word[c->words++] = word;
        }
    }
}

static void obey(struct control *c)
{
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; i++) {
        const struct command *command = &commands[i];

        if (strcmp(command->name, c->word[0]) != 0) {
            continue;
        }
        if (c->words < command->words_min || c->words > command->words_max) {
            answer("error %s: wrong number of words", command->name);
        } else {
            command->run(c);
        }
        return;
    }
    answer("error unknown command '%s'", c->word[0]);
}

int control_serve(struct bench *bench)
{
    struct control c = {.bench = bench, .bytes = malloc(BYTES_MAX + 1)};
    char *line = NULL;
    size_t room = 0;

    while (c.bytes != NULL && !c.quit && getline(&line, &room, stdin) >= 0) {
        split(&c, line);
        if (c.words > 0) {
            obey(&c);
            (void)fflush(stdout);
        }
    }
    free(line);
    free(c.bytes);
    return 0;
}
