// SPDX-License-Identifier: MIT

#include "bench.h"

#include <inttypes.h>
#include <time.h>

#include "eeprom_file.h"

#define QUANTUM_ALONE  16000U // one board: only the PC's side waits for it
#define QUANTUM_SHARED 1000U
#define QUANTUM_MIN    16U

// A board passes the end of its quantum by an instruction and an interrupt's response: pulses are
// handed over so much ahead.
#define LOOK_AHEAD 64U

#define NOISE_PLACE 2000U // of the cycles in which the supplies come on

double bench_wall_s(void)
{
    struct timespec now;

    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

uint32_t bench_quantum(const struct bench *bench)
{
    uint32_t quantum = (bench->boards > 1) ? QUANTUM_SHARED : QUANTUM_ALONE;

    for (int i = 0; bench->boards > 1 && i < bench->boards; i++) {
        const struct uart *uart = &bench->board[i].uart;
        uint32_t frame = (uint32_t)own_time_to_bench(&bench->board[i].time,
                                                     (uint64_t)uart_bit_cycles(uart) *
                                                         uart_bits_before_stop(uart));

        if (uart_can_send(uart) && frame < 2 * quantum) {
            quantum = frame / 2;
        }
    }
    return (quantum < QUANTUM_MIN) ? QUANTUM_MIN : quantum;
}

static void log_pulse(struct bench *bench, const struct pixel_pulse *pulse)
{
    edges_add(&bench->edges,
              &(struct edge){.cycle = pulse->rise, .signal = EDGE_CLOCK, .level = 1});
    edges_add(&bench->edges,
              &(struct edge){.cycle = pulse->fall, .signal = EDGE_CLOCK, .level = 0});
}

static void give_pulse(struct bench *bench, int board, const struct pixel_pulse *pulse)
{
    const struct own_time *time = &bench->board[board].time;
    struct pixel_pulse own = *pulse;

    own.rise = own_time_from_bench(time, pulse->rise);
    own.fall = own_time_from_bench(time, pulse->fall);
    if (!pixel_input_add(&bench->board[board].pixel_input, &own)) {
        board_refuse(&bench->board[board], "pixel clock too fast for the simulator");
    }
    if (bench->pin_log != NULL) {
        (void)fprintf(bench->pin_log,
                      "%" PRIu64 ",%d,%s\n",
                      pulse->rise,
                      board,
                      pixel_edge_name(pulse->kind));
    }
}

static void give_false_edges(struct bench *bench,
                             int board,
                             uint64_t before,
                             uint64_t limit)
{
    struct pixel_pulse pulse;

    while (pin_flaws_false(&bench->pin[board], before, limit, &pulse)) {
        give_pulse(bench, board, &pulse);
    }
}

static void give_clock_pulse(struct bench *bench, int board, struct pixel_pulse pulse)
{
    struct pin_flaws *pin = &bench->pin[board];

    pin_flaws_displace(pin, &pulse);
    give_false_edges(bench, board, pulse.rise, pulse.rise);
    if (pin_flaws_pass(pin, &pulse, pixel_clock_period(&bench->clock))) {
        give_pulse(bench, board, &pulse);
    }
}

// A pin's jitter may bring an edge forward by so much.
static uint32_t most_jitter(const struct bench *bench)
{
    uint32_t most = 0;

    for (int i = 0; i < bench->boards; i++) {
        uint32_t jitter = bench->pin[i].jitter_cycles;

        most = (jitter > most) ? jitter : most;
    }
    return most;
}

static void hand_out_pulses(struct bench *bench, uint64_t before)
{
    struct pixel_pulse pulse;

    while (pixel_clock_next(&bench->clock, before + most_jitter(bench), &pulse)) {
        log_pulse(bench, &pulse);
        for (int i = 0; i < bench->boards; i++) {
            if (!bench->board[i].clock_is_wired) {
                give_clock_pulse(bench, i, pulse);
            }
        }
    }
    for (int i = 0; i < bench->boards; i++) {
        give_false_edges(bench,
                         i,
                         before,
                         pixel_clock_quiet(&bench->clock) - bench->pin[i].jitter_cycles);
    }
}

static bool run_quantum(struct bench *bench, uint64_t end)
{
    bool alive = true;

    hand_out_pulses(bench, end + LOOK_AHEAD);
    for (int i = 0; i < bench->boards; i++) {
        alive = board_run(&bench->board[i], end) && alive;
    }
    bench->cycle = end;
    edges_settle(&bench->edges, end);
    plant_log_settle(&bench->plant_log, end);
    return alive;
}

bool bench_run(struct bench *bench, uint64_t cycle)
{
    while (bench->cycle < cycle) {
        uint64_t end = bench->cycle + bench_quantum(bench);

        if (!run_quantum(bench, (end < cycle) ? end : cycle)) {
            return false;
        }
    }
    return true;
}

void bench_power_up(struct bench *bench, uint64_t cycles, uint64_t seed)
{
    for (int i = 0; i < bench->boards && cycles > 0; i++) {
        struct board *board = &bench->board[i];
        struct scheduled_event on = {.request = SUPPLY_REQUEST_ON};
        struct noise random;

        noise_seed(&random, seed, NOISE_PLACE + (unsigned)i);
        on.cycle = 1 + noise_next(&random) % cycles;
        supply_do(&board->supply, SUPPLY_REQUEST_OFF);
        (void)schedule_add(&board->schedule, &on);
    }
}

bool bench_save_eeprom(const struct bench *bench, int board)
{
    const char *path = bench->eeprom_path[board];

    return path == NULL || eeprom_save(&bench->board[board].eeprom, path);
}

const char *bench_error(const struct bench *bench)
{
    for (int i = 0; i < bench->boards; i++) {
        if (bench->board[i].error[0] != '\0') {
            return bench->board[i].error;
        }
    }
    return NULL;
}
