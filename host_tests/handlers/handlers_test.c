// SPDX-License-Identifier: MIT
//
// The assembly handlers of an image beside their twins in C (handler_bench.h): bus, pixel clock, a
// halted axis, and the steps of a board with one axis.
//
// Usage: handlers_test IMAGE
#include <stdio.h>

#include "handlers/handler_twins.h"

#define BOARD_TEXT_OF(word) #word
#define BOARD_TEXT(word)    BOARD_TEXT_OF(word)
#define RING_BYTES          512U
#define RUNS                10000U

struct board_timer board_timer(unsigned axis)
{
    static const uint8_t numbers[] = {
#define BOARD_AXIS(axis, timer) [axis] = (timer),
#include BOARD_FILE
    };
    static const uint16_t bases[] = {0, 0x80, 0, 0x90, 0xA0, 0x120};
    uint8_t number = numbers[axis];

    return (struct board_timer){
        .base = bases[number],
        .flags = (uint16_t)(0x35U + number),
        .mask = (uint16_t)(0x6EU + number),
        .engine = (uint16_t)(bench_variable("step_engines") + axis * ENGINE_BYTES),
        .ring = (uint16_t)(bench_variable("step_rings") + axis * RING_BYTES),
    };
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        (void)fprintf(stderr, "usage: handlers_test IMAGE\n");
        return 2;
    }
    bench_open(argv[1], BOARD_TEXT(BOARD_MCU));
    run_bus_handlers(RUNS);
    run_clock_handler(4U * RUNS);
    run_halted_handlers(RUNS / 10U);
    run_single_step_handler(4U * RUNS);
    return 0;
}
