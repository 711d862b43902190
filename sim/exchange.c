// SPDX-License-Identifier: MIT

#include "exchange.h"

bool exchange(struct bench *bench,
              const uint8_t *request,
              size_t count,
              uint64_t timeout_cycles,
              uint8_t *answer,
              size_t room,
              size_t *received)
{
    struct bus *bus = &bench->bus;
    uint64_t deadline;
    uint64_t end;
    int byte;

    while (bus_master_receive(bus, bench->cycle, &end) >= 0) {
        // what was received before the request is not its answer
    }
    deadline = bus_master_send(bus, request, count, bench->cycle) + timeout_cycles;

    *received = 0;
    while (bench->cycle < deadline || bus_busy(bus, bench->cycle)) {
        uint64_t next = bench->cycle + bench_quantum(bench);

        if (!bench_run(bench,
                       (next < deadline || bench->cycle >= deadline) ? next : deadline)) {
            return false;
        }
        while ((byte = bus_master_receive(bus, bench->cycle, &end)) >= 0) {
            if (*received < room) {
                answer[(*received)++] = (uint8_t)byte;
            }
            deadline = end + BUS_SILENCE;
        }
    }
    return true;
}
