// SPDX-License-Identifier: MIT

#include "vcd.h"

#include <inttypes.h>
#include <string.h>

#include "cpu_clock.h"

#define UNITS_A_SECOND 10000000000U // of 100 ps
#define FIRST_ID       '!' // identifiers are printable characters; 57 are needed at most

static uint64_t units_per_cycle(void)
{
    return UNITS_A_SECOND / cpu_clock_hz();
}

static void declare_board(
    struct vcd *v, int board, const char *name, int axes, char *next_id)
{
    (void)fprintf(v->file, "$scope module board%d_%s $end\n", board, name);
    for (int axis = 0; axis < axes; axis++) {
        for (unsigned signal = EDGE_STEP; signal <= EDGE_ENABLE; signal++) {
            v->id[board][axis][signal] = (*next_id)++;
            (void)fprintf(v->file,
                          "$var wire 1 %c %s%d $end\n",
                          v->id[board][axis][signal],
                          edge_signal_name(signal),
                          axis);
        }
    }
    for (unsigned signal = EDGE_PERMIT; signal <= EDGE_CLOCK_OUT; signal++) {
        v->id[board][0][signal] = (*next_id)++;
        (void)fprintf(v->file,
                      "$var wire 1 %c %s $end\n",
                      v->id[board][0][signal],
                      edge_signal_name(signal));
    }
    (void)fputs("$upscope $end\n", v->file);
}

bool vcd_open(struct vcd *v,
              const char *path,
              int boards,
              const char *const board_names[],
              const int axes[])
{
    char next_id = FIRST_ID;

    memset(v, 0, sizeof *v);
    v->file = fopen(path, "w");
    if (v->file == NULL) {
        return false;
    }
    (void)fprintf(v->file,
                  "$comment pixstep-sim, %u MHz: %" PRIu64 " units a cycle $end\n"
                  "$timescale 100 ps $end\n"
                  "$scope module pixstep $end\n",
                  cpu_clock_hz() / 1000000U,
                  units_per_cycle());
    v->clock_id = next_id++;
    (void)fprintf(v->file, "$var wire 1 %c PIXEL_CLOCK $end\n", v->clock_id);
    for (int board = 0; board < boards; board++) {
        declare_board(v, board, board_names[board], axes[board], &next_id);
    }
    (void)fputs("$upscope $end\n$enddefinitions $end\n#0\n$dumpvars\n", v->file);
    for (char id = FIRST_ID; id < next_id; id++) {
        (void)fprintf(v->file, "0%c\n", id);
    }
    (void)fputs("$end\n", v->file);
    return true;
}

static void write_time(struct vcd *v, uint64_t cycle)
{
    if (cycle != v->cycle) {
        v->cycle = cycle;
        (void)fprintf(v->file, "#%" PRIu64 "\n", cycle * units_per_cycle());
    }
}

void vcd_edge(struct vcd *v, const struct edge *edge)
{
    char id = (edge->signal == EDGE_CLOCK) ? v->clock_id
                                           : v->id[edge->board][edge->axis][edge->signal];

    write_time(v, edge->cycle);
    (void)fprintf(v->file, "%c%c\n", edge->level != 0 ? '1' : '0', id);
}

void vcd_flush(struct vcd *v)
{
    (void)fflush(v->file);
}

bool vcd_close(struct vcd *v, uint64_t end_cycle)
{
    bool fine;

    write_time(v, end_cycle);
    fine = ferror(v->file) == 0;
    return fclose(v->file) == 0 && fine;
}
