// SPDX-License-Identifier: MIT

#include "unit.h"

#include "cpu_clock.h"

#define GPIOR0       0x3EU // data address, the same on all boards
#define SLICE_CYCLES 16000U

static void print_text(struct bench *bench, uint64_t up_to)
{
    uint64_t end;
    int byte;

    while ((byte = bus_master_receive(&bench->bus, up_to, &end)) >= 0) {
        (void)putchar(byte);
    }
}

int unit_run(struct bench *bench, uint64_t limit_ms)
{
    const struct board *board = &bench->board[0];
    bool alive = true;

    while (alive && bench->cycle < cpu_clock_cycles_of_ms(limit_ms)) {
        alive = bench_run(bench, bench->cycle + SLICE_CYCLES);
        print_text(bench, bench->cycle);
    }
    print_text(bench, UINT64_MAX); // with a frame that the end has cut short
    if (board->uart.waiting) {
        (void)putchar(board->uart.waiting_data);
    }
    (void)fflush(stdout);
    if (board_is_done(board)) {
        return board->avr->data[GPIOR0];
    }
    if (alive) {
        (void)fprintf(stderr,
                      "pixstep-sim: no verdict within %llu ms of simulated time\n",
                      (unsigned long long)limit_ms);
    }
    return UNIT_NO_VERDICT;
}
