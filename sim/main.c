// SPDX-License-Identifier: MIT
//
// pixstep-sim: boards, serial bus, pixel clock and mechanics, simulated to the cycle.
// Exit status: 0 if all went well, 1 if a board stopped on an error or a file could not be written,
// 2 if the command line is wrong; with --unit the image's verdict.

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "bench.h"
#include "control.h"
#include "cpu_clock.h"
#include "csv_file.h"
#include "eeprom_file.h"
#include "options.h"
#include "pty.h"
#include "stats.h"
#include "unit.h"

#define PROGRESS_EVERY_MS 5000U

static struct bench bench; // boards are large and must not move
static volatile sig_atomic_t interrupted;

static void on_signal(int number)
{
    (void)number;
    interrupted = 1;
}

static bool cannot_write(const char *path)
{
    (void)fprintf(stderr, "pixstep-sim: %s: %s\n", path, strerror(errno));
    return false;
}

static bool load_eeprom(struct board *b, const char *path)
{
    char error[512];

    bench.eeprom_path[b->index] = path;
    if (path != NULL && !eeprom_load(&b->eeprom, path, error, sizeof error)) {
        (void)fprintf(stderr, "pixstep-sim: %s\n", error);
        return false;
    }
    return true;
}

static void set_plants(struct board *b, const struct options *o)
{
    for (unsigned axis = 0; axis < BOARD_AXES; axis++) {
        struct plant_settings plant = o->plant[b->index][axis];

        if (!plant.has_seed) {
            plant.seed = o->clock.seed;
            plant.has_seed = true;
        }
        mechanics_set_plant(&b->mechanics, axis, &plant);
    }
}

static bool open_board(const struct options *o, int index)
{
    struct board *b = &bench.board[index];
    const struct board_logs logs = {
        .edges = &bench.edges,
        .serial = (index == 0) ? &bench.serial_log : NULL,
        .plant = &bench.plant_log,
        .wire = (index == 0) ? &bench.wire_log : NULL,
        .switches = bench.switch_log,
    };

    if (!board_open(b,
                    index,
                    o->board_name[index],
                    o->board_image[index],
                    o->oscillator_ppm[index],
                    &bench.bus,
                    &logs)) {
        (void)fprintf(stderr, "pixstep-sim: %s\n", b->error);
        return false;
    }
    bench.boards++;
    board_seed(b, o->clock.seed);
    pin_flaws_init(&bench.pin[index], o->clock.seed, (unsigned)index);
    if (!load_eeprom(b, o->eeprom_path[index])) {
        return false;
    }
    set_plants(b, o);
    return true;
}

static bool open_boards(const struct options *o)
{
    for (int i = 0; i < o->boards; i++) {
        if (!open_board(o, i)) {
            return false;
        }
    }
    for (int i = 0; i < o->boards; i++) {
        if (o->clock_from[i] != 0) {
            board_wire_clock(&bench.board[o->clock_from[i] - 1], &bench.board[i]);
        }
    }
    return true;
}

static bool open_plain_log(FILE **file, const char *path, const char *header)
{
    return csv_open(file, path, header) || cannot_write(path);
}

static bool open_plain_logs(const struct options *o)
{
    return open_plain_log(&bench.pin_log, o->pin_log_path, "cycle,board,edge") &&
           open_plain_log(
               &bench.switch_log, o->switch_log_path, "cycle,board,axis,switch,level");
}

static bool open_outputs(const struct options *o)
{
    const char *names[BUS_BOARDS] = {0};
    int axes[BUS_BOARDS] = {0};

    for (int i = 0; i < o->boards; i++) {
        names[i] = o->board_name[i];
        axes[i] = board_kind_by_name(o->board_name[i])->axes;
    }
    if (o->vcd_path != NULL) {
        if (!vcd_open(&bench.vcd, o->vcd_path, o->boards, names, axes)) {
            return cannot_write(o->vcd_path);
        }
        bench.has_vcd = true;
    }
    if (!edges_open(&bench.edges, o->edges_path, bench.has_vcd ? &bench.vcd : NULL)) {
        return cannot_write(o->edges_path);
    }
    if (!pixel_clock_open(&bench.clock, &o->clock, o->clock_log_path)) {
        return cannot_write(o->clock_log_path);
    }
    if (!serial_log_open(&bench.serial_log, o->serial_log_path)) {
        return cannot_write(o->serial_log_path);
    }
    if (!plant_log_open(&bench.plant_log, o->plant_log_path)) {
        return cannot_write(o->plant_log_path);
    }
    if (!wire_log_open(&bench.wire_log, o->wire_log_path)) {
        return cannot_write(o->wire_log_path);
    }
    bench.bus.log = &bench.wire_log;
    return open_plain_logs(o);
}

static int run_ms(uint64_t ms)
{
    bool alive = true;

    for (uint64_t done = 0; alive && done < ms && !interrupted;) {
        uint64_t step = (ms - done < PROGRESS_EVERY_MS) ? ms - done : PROGRESS_EVERY_MS;

        alive = bench_run(&bench, bench.cycle + cpu_clock_cycles_of_ms(step));
        done += step;
        if (done < ms && isatty(STDERR_FILENO) != 0) {
            (void)fprintf(stderr,
                          "pixstep-sim: %llu of %llu ms\n",
                          (unsigned long long)done,
                          (unsigned long long)ms);
        }
    }
    stats_write(stdout, &bench);
    (void)putchar('\n');
    return alive ? 0 : 1;
}

static int run_mode(const struct options *o)
{
    switch (o->mode) {
    case MODE_CONTROL:
        return control_serve(&bench);
    case MODE_PTY:
        return pty_serve(&bench, &interrupted);
    case MODE_UNIT:
        return unit_run(&bench, o->unit_limit_ms);
    case MODE_RUN_MS:
    case MODE_NONE:
    default:
        return run_ms(o->run_ms);
    }
}

// A run that went well fails if one of its files could not be written.
static void check_closed(bool fine, const char *path, int *status)
{
    if (!fine) {
        (void)cannot_write(path);
        *status = (*status == 0) ? 1 : *status;
    }
}

static int close_all(const struct options *o, int status)
{
    const char *error = bench_error(&bench);

    check_closed(edges_close(&bench.edges), o->edges_path, &status);
    if (bench.has_vcd) {
        check_closed(vcd_close(&bench.vcd, bench.cycle), o->vcd_path, &status);
    }
    check_closed(serial_log_close(&bench.serial_log), o->serial_log_path, &status);
    check_closed(plant_log_close(&bench.plant_log), o->plant_log_path, &status);
    check_closed(csv_close(&bench.switch_log), o->switch_log_path, &status);
    check_closed(csv_close(&bench.pin_log), o->pin_log_path, &status);
    check_closed(wire_log_close(&bench.wire_log), o->wire_log_path, &status);
    check_closed(pixel_clock_close(&bench.clock), o->clock_log_path, &status);
    if (error != NULL) {
        (void)fprintf(stderr, "pixstep-sim: %s\n", error);
    }
    for (int i = 0; i < bench.boards; i++) {
        check_closed(bench_save_eeprom(&bench, i), bench.eeprom_path[i], &status);
        board_close(&bench.board[i]);
    }
    return status;
}

int main(int argc, char **argv)
{
    struct options options;

    options_read(&options, argc, argv);
    bus_init(&bench.bus);
    if (!open_outputs(&options) || !open_boards(&options)) {
        return 2;
    }
    bench_power_up(
        &bench, cpu_clock_cycles_of_ms(options.power_up_ms), options.clock.seed);
    (void)signal(SIGINT, on_signal);
    (void)signal(SIGTERM, on_signal);
    bench.wall_started_s = bench_wall_s();
    return close_all(&options, run_mode(&options));
}
