// SPDX-License-Identifier: MIT

#include "bench.h"

#include <time.h>

#include "eeprom_file.h"

#define QUANTUM_ALONE  16000U // one board: only the PC's side waits for it
#define QUANTUM_SHARED 1000U
#define QUANTUM_MIN    16U

// A board passes the end of its quantum by an instruction and an interrupt's response: pulses are
// handed over so much ahead.
#define LOOK_AHEAD 64U

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
        uint32_t frame = uart_bit_cycles(uart) * uart_bits_before_stop(uart);

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

static void hand_out_pulses(struct bench *bench, uint64_t before)
{
    struct pixel_pulse pulse;

    while (pixel_clock_next(&bench->clock, before, &pulse)) {
        for (int i = 0; i < bench->boards; i++) {
            if (!pixel_input_add(&bench->board[i].pixel_input, &pulse)) {
                board_refuse(&bench->board[i], "pixel clock too fast for the simulator");
            } else if (i == 0) {
                log_pulse(bench, &pulse);
            }
        }
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
