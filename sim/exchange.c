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
    struct line *line = &bench->line;
    uint64_t deadline;
    uint64_t end;
    int byte;

    while (line_master_receive(line, bench->cycle, &end) >= 0) {
        // what came before the request is not its answer
    }
    deadline = line_master_send(line, request, count, bench->cycle) + timeout_cycles;

    *received = 0;
    while (bench->cycle < deadline || line_busy(line, bench->cycle)) {
        uint64_t next = bench->cycle + bench_quantum(bench);

        if (!bench_run(bench,
                       (next < deadline || bench->cycle >= deadline) ? next : deadline)) {
            return false;
        }
        while ((byte = line_master_receive(line, bench->cycle, &end)) >= 0) {
            if (*received < room) {
                answer[(*received)++] = (uint8_t)byte;
            }
            deadline = end + LINE_SILENCE;
        }
    }
    return true;
}
