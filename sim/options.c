// SPDX-License-Identifier: MIT

#include "options.h"

#include <errno.h>
#include <getopt.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cpu_clock.h"
#include "plant_parse.h"

#define DEFAULT_START_MS      10.0
#define DEFAULT_UNIT_LIMIT_MS 600000U
#define PPM_MOST              1e5
#define HZ_MOST               60000U
#define JITTER_MOST_NS        10000000U
#define REST_MOST_MS          3600000.0
#define POWER_UP_MOST_MS      60000U
#define OSCILLATOR_MOST       2e4 // ppm: more, and serial frames do not fit

static const char manual_of_boards[] =
    "usage: pixstep-sim --board NAME=IMAGE.elf [--board ...] [options] MODE\n"
    "Runs one to four simulated boards, exact to the cycle, on one serial bus and one "
    "pixel clock.\n"
    "\n"
    "  --board NAME=IMAGE     a board (uno, mega, m1284) and its firmware; board i "
    "answers "
    "as unit i + 1\n"
    "  --plant B.A:PARAMETERS mechanics of board B's axis A; parameters joined by "
    "commas, "
    "any of these\n"
    "                         (steps, or ticks of the CPU clock):\n"
    "    play=N               between motor and load (0)\n"
    "    travel=MIN..MAX      limit switches closed at and beyond these (no switches)\n"
    "    over=N               from a limit switch to its hard stop (100)\n"
    "    home=N               home switch closed above this (no switch)\n"
    "    hyst=N               it opens so many steps below where it closed (8)\n"
    "    start=N              where motor and load are at reset (0)\n"
    "    taken_up=plus|minus  in which direction the play is taken up then (plus)\n"
    "    active=low|high      level of a closed switch (low)\n"
    "    delay=TICKS          contacts follow the load so much later (0; at most "
    "16000000)\n"
    "    bounce=N             after each change a contact has N more edges (0; even, at "
    "most 64)\n"
    "    bounce_ticks=M       in the M ticks after the first (0)\n"
    "    seed=S               of the places of these edges (that of --seed)\n"
    "    stuck=SWITCH:STATE   home, minus or plus; closed, open or free; several are "
    "joined by +,\n"
    "                         stuck=none frees all\n"
    "  --eeprom B=FILE        board B's EEPROM, its bytes: loaded if the file is there "
    "(else erased,\n"
    "                         0xff), written at the end and by the control command "
    "flush\n"
    "  --oscillator-ppm B=X   board B's oscillator is so much faster; that of board 0 is "
    "the "
    "time of the\n"
    "                         run, in whose cycles all commands and files count\n"
    "  --clock-wire A:B       pin CLOCK_OUT of board A is wired to PIXEL_CLOCK of board "
    "B: "
    "of A itself,\n"
    "                         or of a later board; B gets no edge of --pixel-hz\n"
    "  --power-up-ms M        each board gets its supply at a random cycle of its own "
    "within the\n"
    "                         first M ms (0: all at the start)\n";

static const char manual_of_runs[] =
    "pixel clock:\n"
    "  --pixel-hz N[/D]       frequency, exact (none: no clock)\n"
    "  --pixel-ppm X          frequency error\n"
    "  --pixel-jitter-ns J    each edge is off by at most J\n"
    "  --pixel-jitter-rms-ns J  normally distributed, of this standard deviation\n"
    "  --pixel-wander-ppm X   the error swings by X to either side, once in 1000 edges\n"
    "  --pixel-step X@N       X ppm more from edge N on, counted from 0\n"
    "  --pixel-drop K         one edge of K is missing\n"
    "  --pixel-double K       one edge of K is followed by a false one\n"
    "  --pixel-gate N,M       N edges, then a rest of M ms besides the period, and so "
    "on\n"
    "  --pixel-start-ms M     first rising edge (default 10)\n"
    "  --seed S               of everything random (default 1)\n"
    "output:\n"
    "  --edges FILE           every STEP, DIR, ENABLE and PERMIT edge:\n"
    "                         cycle,board,axis,signal,level (PERMIT is of the whole "
    "board: axis 0)\n"
    "  --clock-log FILE       every edge of the pixel clock, true, missing and false "
    "ones:\n"
    "                         cycle,true_cycle_x1000,edge (sim/pixel_clock.h)\n"
    "  --pin-log FILE         every edge of the clock as it reaches each board's pin, "
    "false "
    "ones\n"
    "                         included: cycle,board,edge\n"
    "  --serial-log FILE      the first board's serial bytes: cycle,direction,byte "
    "(hex);\n"
    "                         rx at the middle of the stop bit, tx at the start bit\n"
    "  --plant-log FILE       motor and load of every --plant, at each change:\n"
    "                         cycle,board,axis,motor,load\n"
    "  --switch-log FILE      every edge of a home or limit pin: "
    "cycle,board,axis,switch,level\n"
    "  --wire-log FILE        all that reaches the first board, pins and serial frames: "
    "cycle,wire,\n"
    "                         levels,bit_cycles_x1000 (sim/wire_log.h)\n"
    "  --vcd FILE             waveforms for GTKWave\n"
    "mode, one of:\n"
    "  --control              commands on standard input, answers on standard output "
    "(sim/control.h\n"
    "                         lists them: run, tx, peek, pin, power, reset, hang, eeprom "
    "and others)\n"
    "  --pty                  the serial bus as a pseudo terminal, in real time\n"
    "  --run-ms N             so long, then statistics (JSON) on standard output\n"
    "  --unit                 a test image: its text, and GPIOR0 as exit status\n"
    "  --unit-limit-ms N      give a test image up after so long (default 600000)\n";

__attribute__((noreturn, format(printf, 1, 2))) static void fail(const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    (void)fputs("pixstep-sim: ", stderr);
    (void)vfprintf(stderr, format, arguments);
    (void)fputc('\n', stderr);
    va_end(arguments);
    exit(2);
}

static uint64_t read_whole(const char *option,
                           const char *text,
                           uint64_t least,
                           uint64_t most)
{
    char *end;
    unsigned long long value;

    errno = 0;
    value = strtoull(text, &end, 10);
    if (text[0] < '0' || text[0] > '9' || *end != '\0' || errno != 0 || value < least ||
        value > most) {
        fail("%s '%s': expected a whole number from %llu to %llu",
             option,
             text,
             (unsigned long long)least,
             (unsigned long long)most);
    }
    return value;
}

static double read_real(const char *option, const char *text, double least, double most)
{
    char *end;
    double value = strtod(text, &end);

    if (end == text || *end != '\0' || !(value >= least && value <= most)) {
        fail("%s '%s': expected a number from %g to %g", option, text, least, most);
    }
    return value;
}

// The first board's clock is the time of the run.
static void check_kind(const struct options *o, const char *name)
{
    const struct board_kind *kind = board_kind_by_name(name);

    if (kind == NULL) {
        fail("--board: unknown board '%s': one of %s", name, board_kind_names());
    }
    if (o->boards == 0) {
        cpu_clock_set(kind->cpu_hz);
    }
}

static void read_board(struct options *o, char *text)
{
    char *equals = strchr(text, '=');

    if (equals == NULL || equals == text || equals[1] == '\0') {
        fail("--board '%s': expected NAME=IMAGE.elf", text);
    }
    if (o->boards == BUS_BOARDS) {
        fail("--board: at most %d boards", BUS_BOARDS);
    }
    *equals = '\0';
    check_kind(o, text);
    o->board_name[o->boards] = text;
    o->board_image[o->boards] = equals + 1;
    o->boards++;
}

static void read_hz(struct options *o, char *text)
{
    char *slash = strchr(text, '/');

    o->clock.hz_den = 1;
    if (slash != NULL) {
        *slash = '\0';
        o->clock.hz_den = (uint32_t)read_whole("--pixel-hz", slash + 1, 1, UINT32_MAX);
    }
    o->clock.hz_num = (uint32_t)read_whole("--pixel-hz", text, 1, UINT32_MAX);
    if (o->clock.hz_num / o->clock.hz_den > HZ_MOST) {
        fail(
            "--pixel-hz %u/%u: at most %u Hz", o->clock.hz_num, o->clock.hz_den, HZ_MOST);
    }
}

static void read_plant(struct options *o, char *text)
{
    char error[128];
    unsigned board = (unsigned)(unsigned char)text[0] - '0';
    unsigned axis = (board < BUS_BOARDS && text[1] == '.')
                        ? (unsigned)(unsigned char)text[2] - '0'
                        : BOARD_AXES;

    if (axis >= BOARD_AXES || text[3] != ':') {
        fail("--plant '%s': expected BOARD.AXIS:PARAMETERS, as in 0.1:play=40", text);
    }
    if (!plant_parse(
            &o->plant[board][axis], text + strlen("0.0:"), error, sizeof error)) {
        fail("--plant %u.%u: %s", board, axis, error);
    }
}

static void read_eeprom(struct options *o, const char *text)
{
    unsigned board = (unsigned)(unsigned char)text[0] - '0';

    if (board >= BUS_BOARDS || text[1] != '=' || text[2] == '\0') {
        fail("--eeprom '%s': expected BOARD=FILE, as in 0=eeprom.bin", text);
    }
    o->eeprom_path[board] = text + 2;
}

// One clock reaches a board's input.
static void read_clock_wire(struct options *o, const char *text)
{
    unsigned from = (unsigned)(unsigned char)text[0] - '0';
    unsigned to = (from < BUS_BOARDS && text[1] == ':')
                      ? (unsigned)(unsigned char)text[2] - '0'
                      : BUS_BOARDS;

    if (to >= BUS_BOARDS || to < from || text[3] != '\0' || o->clock_from[to] != 0) {
        fail("--clock-wire '%s': expected FROM:TO, as in 0:1, two boards of which TO is "
             "not the earlier one and has no other clock wire",
             text);
    }
    o->clock_from[to] = (int)from + 1;
}

static void read_oscillator(struct options *o, const char *text)
{
    unsigned board = (unsigned)(unsigned char)text[0] - '0';

    if (board == 0 || board >= BUS_BOARDS || text[1] != '=') {
        fail("--oscillator-ppm '%s': expected BOARD=PPM, as in 1=-400, of board 1 or a "
             "later one",
             text);
    }
    o->oscillator_ppm[board] =
        read_real("--oscillator-ppm", text + 2, -OSCILLATOR_MOST, OSCILLATOR_MOST);
}

static void read_step(struct options *o, char *text)
{
    char *at = strchr(text, '@');

    if (at == NULL) {
        fail("--pixel-step '%s': expected PPM@EDGE, as in 1000@200", text);
    }
    *at = '\0';
    o->clock.step_ppm = read_real("--pixel-step", text, -PPM_MOST, PPM_MOST);
    o->clock.step_edge = read_whole("--pixel-step", at + 1, 1, UINT32_MAX);
}

static void read_gate(struct options *o, char *text)
{
    char *comma = strchr(text, ',');

    if (comma == NULL) {
        fail("--pixel-gate '%s': expected EDGES,REST_MS, as in 512,20", text);
    }
    *comma = '\0';
    o->clock.gate_edges = (uint32_t)read_whole("--pixel-gate", text, 1, UINT32_MAX);
    o->clock.gate_rest_ms = read_real("--pixel-gate", comma + 1, 0, REST_MOST_MS);
}

static void set_mode(struct options *o, enum run_mode mode)
{
    if (o->mode != MODE_NONE) {
        fail("only one of --control, --pty, --run-ms and --unit");
    }
    o->mode = mode;
}

// In groups, each of which begins where the one before ends: boards, the clock, output files,
// modes.
enum option_id {
    OPTION_BOARD = 1000,
    OPTION_PLANT,
    OPTION_EEPROM,
    OPTION_OSCILLATOR,
    OPTION_CLOCK_WIRE,
    OPTION_POWER_UP,
    OPTION_HZ,
    OPTION_PPM,
    OPTION_JITTER,
    OPTION_JITTER_RMS,
    OPTION_WANDER,
    OPTION_STEP,
    OPTION_DROP,
    OPTION_DOUBLE,
    OPTION_GATE,
    OPTION_START,
    OPTION_SEED,
    OPTION_EDGES,
    OPTION_CLOCK_LOG,
    OPTION_PIN_LOG,
    OPTION_SERIAL_LOG,
    OPTION_PLANT_LOG,
    OPTION_SWITCH_LOG,
    OPTION_WIRE_LOG,
    OPTION_VCD,
    OPTION_CONTROL,
    OPTION_PTY,
    OPTION_RUN_MS,
    OPTION_UNIT,
    OPTION_UNIT_LIMIT,
    OPTION_HELP,
};

static const struct option table[] = {
    {"board", required_argument, NULL, OPTION_BOARD},
    {"plant", required_argument, NULL, OPTION_PLANT},
    {"eeprom", required_argument, NULL, OPTION_EEPROM},
    {"oscillator-ppm", required_argument, NULL, OPTION_OSCILLATOR},
    {"clock-wire", required_argument, NULL, OPTION_CLOCK_WIRE},
    {"power-up-ms", required_argument, NULL, OPTION_POWER_UP},
    {"pixel-hz", required_argument, NULL, OPTION_HZ},
    {"pixel-ppm", required_argument, NULL, OPTION_PPM},
    {"pixel-jitter-ns", required_argument, NULL, OPTION_JITTER},
    {"pixel-jitter-rms-ns", required_argument, NULL, OPTION_JITTER_RMS},
    {"pixel-wander-ppm", required_argument, NULL, OPTION_WANDER},
    {"pixel-step", required_argument, NULL, OPTION_STEP},
    {"pixel-drop", required_argument, NULL, OPTION_DROP},
    {"pixel-double", required_argument, NULL, OPTION_DOUBLE},
    {"pixel-gate", required_argument, NULL, OPTION_GATE},
    {"pixel-start-ms", required_argument, NULL, OPTION_START},
    {"seed", required_argument, NULL, OPTION_SEED},
    {"edges", required_argument, NULL, OPTION_EDGES},
    {"clock-log", required_argument, NULL, OPTION_CLOCK_LOG},
    {"pin-log", required_argument, NULL, OPTION_PIN_LOG},
    {"serial-log", required_argument, NULL, OPTION_SERIAL_LOG},
    {"plant-log", required_argument, NULL, OPTION_PLANT_LOG},
    {"switch-log", required_argument, NULL, OPTION_SWITCH_LOG},
    {"wire-log", required_argument, NULL, OPTION_WIRE_LOG},
    {"vcd", required_argument, NULL, OPTION_VCD},
    {"control", no_argument, NULL, OPTION_CONTROL},
    {"pty", no_argument, NULL, OPTION_PTY},
    {"run-ms", required_argument, NULL, OPTION_RUN_MS},
    {"unit", no_argument, NULL, OPTION_UNIT},
    {"unit-limit-ms", required_argument, NULL, OPTION_UNIT_LIMIT},
    {"help", no_argument, NULL, OPTION_HELP},
    {NULL, 0, NULL, 0},
};

// What is wrong with the clock's edges, one by one.
static void read_flaw_option(struct options *o, int id, char *value)
{
    switch (id) {
    case OPTION_JITTER:
        o->clock.jitter_ns =
            (uint32_t)read_whole("--pixel-jitter-ns", value, 0, JITTER_MOST_NS);
        break;
    case OPTION_JITTER_RMS:
        o->clock.jitter_rms_ns =
            (uint32_t)read_whole("--pixel-jitter-rms-ns", value, 0, JITTER_MOST_NS);
        break;
    case OPTION_STEP:
        read_step(o, value);
        break;
    case OPTION_GATE:
        read_gate(o, value);
        break;
    case OPTION_DROP:
        o->clock.drop_every = (uint32_t)read_whole("--pixel-drop", value, 2, UINT32_MAX);
        break;
    default:
        o->clock.double_every =
            (uint32_t)read_whole("--pixel-double", value, 1, UINT32_MAX);
        break;
    }
}

static void read_clock_option(struct options *o, int id, char *value)
{
    switch (id) {
    case OPTION_HZ:
        read_hz(o, value);
        break;
    case OPTION_PPM:
        o->clock.ppm = read_real("--pixel-ppm", value, -PPM_MOST, PPM_MOST);
        break;
    case OPTION_WANDER:
        o->clock.wander_ppm = read_real("--pixel-wander-ppm", value, 0, PPM_MOST);
        break;
    case OPTION_START:
        o->clock.start_ms = read_real("--pixel-start-ms", value, 0.01, 1e9);
        break;
    case OPTION_SEED:
        o->clock.seed = read_whole("--seed", value, 0, UINT64_MAX);
        break;
    default:
        read_flaw_option(o, id, value);
        break;
    }
}

static void read_mode_option(struct options *o, int id, const char *value)
{
    switch (id) {
    case OPTION_CONTROL:
        set_mode(o, MODE_CONTROL);
        break;
    case OPTION_PTY:
        set_mode(o, MODE_PTY);
        break;
    case OPTION_UNIT:
        set_mode(o, MODE_UNIT);
        break;
    case OPTION_UNIT_LIMIT:
        o->unit_limit_ms = read_whole("--unit-limit-ms", value, 1, UINT32_MAX);
        break;
    default:
        set_mode(o, MODE_RUN_MS);
        o->run_ms = read_whole("--run-ms", value, 1, UINT32_MAX);
        break;
    }
}

static void read_output_option(struct options *o, int id, const char *path)
{
    switch (id) {
    case OPTION_EDGES:
        o->edges_path = path;
        break;
    case OPTION_CLOCK_LOG:
        o->clock_log_path = path;
        break;
    case OPTION_PIN_LOG:
        o->pin_log_path = path;
        break;
    case OPTION_SERIAL_LOG:
        o->serial_log_path = path;
        break;
    case OPTION_PLANT_LOG:
        o->plant_log_path = path;
        break;
    case OPTION_SWITCH_LOG:
        o->switch_log_path = path;
        break;
    case OPTION_WIRE_LOG:
        o->wire_log_path = path;
        break;
    default:
        o->vcd_path = path;
        break;
    }
}

static void read_board_option(struct options *o, int id, char *value)
{
    switch (id) {
    case OPTION_BOARD:
        read_board(o, value);
        break;
    case OPTION_PLANT:
        read_plant(o, value);
        break;
    case OPTION_EEPROM:
        read_eeprom(o, value);
        break;
    case OPTION_OSCILLATOR:
        read_oscillator(o, value);
        break;
    case OPTION_CLOCK_WIRE:
        read_clock_wire(o, value);
        break;
    default:
        o->power_up_ms = read_whole("--power-up-ms", value, 0, POWER_UP_MOST_MS);
        break;
    }
}

static void read_option(struct options *o, int id, char *value)
{
    switch (id) {
    case OPTION_HELP:
        (void)fputs(manual_of_boards, stdout);
        (void)fputs(manual_of_runs, stdout);
        exit(0);
    case '?':
        exit(2); // getopt has printed what is wrong
    default:
        if (id >= OPTION_CONTROL) {
            read_mode_option(o, id, value);
        } else if (id >= OPTION_EDGES) {
            read_output_option(o, id, value);
        } else if (id >= OPTION_HZ) {
            read_clock_option(o, id, value);
        } else {
            read_board_option(o, id, value);
        }
        break;
    }
}

static void check_eeproms(const struct options *o)
{
    for (int board = o->boards; board < BUS_BOARDS; board++) {
        if (o->eeprom_path[board] != NULL) {
            fail("--eeprom %d: there is no such board", board);
        }
    }
}

static void check_clock_wires(const struct options *o)
{
    for (int board = o->boards; board < BUS_BOARDS; board++) {
        if (o->clock_from[board] != 0) {
            fail("--clock-wire %d:%d: there is no board %d",
                 o->clock_from[board] - 1,
                 board,
                 board);
        }
    }
}

static void check_plants(const struct options *o)
{
    for (int board = 0; board < BUS_BOARDS; board++) {
        int axes =
            (board < o->boards) ? board_kind_by_name(o->board_name[board])->axes : 0;

        for (int axis = axes; axis < BOARD_AXES; axis++) {
            if (o->plant[board][axis].present) {
                fail("--plant %d.%d: there is no such axis", board, axis);
            }
        }
    }
}

void options_read(struct options *o, int argc, char **argv)
{
    int id;

    memset(o, 0, sizeof *o);
    o->clock.start_ms = DEFAULT_START_MS;
    o->clock.seed = 1;
    o->unit_limit_ms = DEFAULT_UNIT_LIMIT_MS;
    argv[0] = (char[]){"pixstep-sim"}; // for getopt's own messages
    while ((id = getopt_long(argc, argv, "", table, NULL)) != -1) {
        read_option(o, id, optarg);
    }
    if (optind < argc) {
        fail("'%s' is not an option (--help lists them)", argv[optind]);
    }
    if (o->boards == 0) {
        fail("no board: --board NAME=IMAGE.elf (--help explains)");
    }
    if (o->mode == MODE_NONE) {
        fail("no mode: one of --control, --pty, --run-ms N and --unit (--help explains)");
    }
    check_plants(o);
    check_eeproms(o);
    check_clock_wires(o);
}
