// SPDX-License-Identifier: MIT

#include "control.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "control_board.h"
#include "control_bus.h"
#include "control_clock.h"
#include "control_words.h"
#include "cpu_clock.h"
#include "csv_file.h"
#include "exchange.h"
#include "plant_parse.h"
#include "stats.h"

#define TIMEOUT_MS 100U

static const struct outputs_axis *find_outputs(struct control *c)
{
    struct board *board;
    unsigned axis;

    return control_board_axis(c, &board, &axis) ? &board->outputs.axis[axis] : NULL;
}

static void answer_stopped(const struct control *c)
{
    const char *error = bench_error(c->bench);

    control_answer("error %s", (error != NULL) ? error : "a board's program has ended");
}

static void do_run(struct control *c)
{
    uint64_t cycles;
    uint64_t end;

    if (!control_number(c->word[1], UINT64_MAX / 2, &cycles)) {
        return;
    }
    end = c->bench->cycle + cycles;
    if (pty_is_open(&c->pty) ? pty_run(&c->pty, end) : bench_run(c->bench, end)) {
        control_answer("ok %" PRIu64, c->bench->cycle);
    } else {
        answer_stopped(c);
    }
}

static void do_tx(struct control *c)
{
    uint64_t timeout = cpu_clock_cycles_of_ms(TIMEOUT_MS);
    size_t count;
    size_t received;

    if (pty_is_open(&c->pty)) {
        control_answer("error tx: the bus belongs to the pseudo terminal");
        return;
    }
    if (!control_bytes(c, c->word[1], &count) ||
        (c->words > 2 && !control_number(c->word[2], UINT64_MAX / 2, &timeout))) {
        return;
    }
    if (exchange(
            c->bench, c->bytes, count, timeout, c->bytes, CONTROL_BYTES_MAX, &received)) {
        control_answer_hex("rx", c->bytes, received);
        control_answer(" %" PRIu64, c->bench->cycle);
    } else {
        answer_stopped(c);
    }
}

static void do_steps(struct control *c)
{
    const struct outputs_axis *axis = find_outputs(c);

    if (axis != NULL) {
        control_answer("steps %" PRId64 " %" PRIu64, axis->steps_signed, c->bench->cycle);
    }
}

static void do_counts(struct control *c)
{
    const struct outputs_axis *axis = find_outputs(c);

    if (axis != NULL) {
        control_answer("counts %" PRIu64, axis->steps_rising);
    }
}

static void do_last(struct control *c)
{
    const struct outputs_axis *axis = find_outputs(c);

    if (axis != NULL) {
        control_answer("last %" PRIu64 " %" PRId64 " %" PRIu64 " %" PRIu64,
                       axis->steps_rising,
                       axis->steps_signed,
                       axis->step_cycles[0],
                       axis->step_cycles[1]);
    }
}

static void do_plant(struct control *c)
{
    struct board *board;
    unsigned axis;

    if (control_board_axis(c, &board, &axis)) {
        const struct plant *plant = &board->mechanics.axis[axis].plant;

        control_answer("plant %" PRId64 " %" PRId64, plant->motor, plant->load);
    }
}

static void do_knobs(struct control *c)
{
    struct board *board;
    unsigned axis;
    struct plant_settings settings;
    char error[128];

    if (!control_board_axis(c, &board, &axis)) {
        return;
    }
    settings = board->mechanics.axis[axis].plant.settings;
    settings.has_start = settings.has_seed = false; // unless the text names them
    if (plant_parse(&settings, c->word[3], error, sizeof error)) {
        mechanics_change_plant(&board->mechanics, axis, &settings);
        control_answer("ok");
    } else {
        control_answer("error knobs: %s", error);
    }
}

// The level that the pin of a switch reads.
static bool switch_level(const struct board *b, unsigned axis, unsigned which)
{
    const struct board_pin *pin =
        switches_pin(&b->switches, axis, (enum plant_switch)which);

    return pin != NULL && ports_level(&b->ports, pin->port, pin->bit);
}

static void do_switches(struct control *c)
{
    struct board *board;
    unsigned axis;
    const struct switch_state *state;

    if (!control_board_axis(c, &board, &axis)) {
        return;
    }
    state = board->switches.state[axis];
    (void)fputs("switches", stdout);
    for (unsigned i = 0; i < PLANT_SWITCHES; i++) {
        (void)printf(
            " %" PRIu64 " %d", state[i].cycle, switch_level(board, axis, i) ? 1 : 0);
    }
    control_answer(" %" PRIu64, state[PLANT_HOME].first_cycle);
}

static void do_stats(struct control *c)
{
    stats_write(stdout, c->bench);
    control_answer("%s", "");
}

static void do_mark(struct control *c)
{
    for (int i = 0; i < c->bench->boards; i++) {
        irq_stats_mark(&c->bench->board[i].stats);
    }
    control_answer("ok %" PRIu64, c->bench->cycle);
}

static void do_flush(struct control *c)
{
    edges_flush(&c->bench->edges);
    serial_log_flush(&c->bench->serial_log);
    wire_log_flush(&c->bench->wire_log);
    plant_log_flush(&c->bench->plant_log);
    csv_flush(c->bench->switch_log);
    csv_flush(c->bench->pin_log);
    csv_flush(c->bench->clock.log);
    for (int i = 0; i < c->bench->boards; i++) {
        if (!bench_save_eeprom(c->bench, i)) {
            control_answer(
                "error flush: %s: %s", c->bench->eeprom_path[i], strerror(errno));
            return;
        }
    }
    control_answer("ok");
}

static void do_pty(struct control *c)
{
    if (pty_is_open(&c->pty) || pty_open(&c->pty, c->bench)) {
        control_answer("pty %s", pty_name(&c->pty));
    } else {
        control_answer("error no pseudo terminal: %s", strerror(errno));
    }
}

static void do_lost(struct control *c)
{
    control_answer("lost %" PRIu64, c->pty.lost_cycles);
}

static void do_quit(struct control *c)
{
    c->quit = true;
    control_answer("ok");
}

static const struct command commands[] = {
    {"run", 2, 2, do_run},
    {"tx", 2, 3, do_tx},
    {"steps", 3, 3, do_steps},
    {"counts", 3, 3, do_counts},
    {"last", 3, 3, do_last},
    {"plant", 3, 3, do_plant},
    {"knobs", 4, 4, do_knobs},
    {"switches", 3, 3, do_switches},
    {"stats", 1, 1, do_stats},
    {"mark", 1, 1, do_mark},
    {"flush", 1, 1, do_flush},
    {"pty", 1, 1, do_pty},
    {"lost", 1, 1, do_lost},
    {"quit", 1, 1, do_quit},
    {NULL, 0, 0, NULL},
};

static void split_words(struct control *c, char *text)
{
    char *rest = text;
    char *word;

    c->words = 0;
    while ((word = strsep(&rest, " \t\r\n")) != NULL && c->words < CONTROL_WORDS_MAX) {
        if (word[0] != '\0') {
            c->word[c->words++] = word;
        }
    }
}

static const struct command *find_command(const struct command *list, const char *name)
{
    while (list->name != NULL && strcmp(list->name, name) != 0) {
        list++;
    }
    return (list->name != NULL) ? list : NULL;
}

static void execute(struct control *c)
{
    const struct command *command = find_command(commands, c->word[0]);

    if (command == NULL) {
        command = find_command(control_board_commands, c->word[0]);
    }
    if (command == NULL) {
        command = find_command(control_bus_commands, c->word[0]);
    }
    if (command == NULL) {
        command = find_command(control_clock_commands, c->word[0]);
    }
    if (command == NULL) {
        control_answer("error unknown command '%s'", c->word[0]);
    } else if (c->words < command->words_min || c->words > command->words_max) {
        control_answer("error %s: wrong number of words", command->name);
    } else {
        command->execute(c);
    }
}

int control_serve(struct bench *bench)
{
    struct control c = {.bench = bench, .bytes = malloc(CONTROL_BYTES_MAX + 1)};
    char *text = NULL;
    size_t room = 0;

    while (c.bytes != NULL && !c.quit && getline(&text, &room, stdin) >= 0) {
        split_words(&c, text);
        if (c.words > 0) {
            execute(&c);
            (void)fflush(stdout);
        }
    }
    pty_close(&c.pty);
    free(text);
    free(c.bytes);
    return 0;
}
