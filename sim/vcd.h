// SPDX-License-Identifier: MIT
//
// Waveforms for GTKWave: a scope for each board with STEP, DIR and ENABLE of its axes and its
// PERMIT, and the pixel clock. A cycle is 62.5 ns; VCD knows only powers of ten, so the time scale
// is 100 ps and a cycle 625 units.
//
//   pixstep                          scope of everything
//     PIXEL_CLOCK
//     board0_mega                    scope of a board
//       STEP0 DIR0 ENABLE0 STEP1 ... ENABLE3 PERMIT
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "edge.h"

#define VCD_BOARDS 4
#define VCD_AXES   4

struct vcd {
    FILE *file;
    uint64_t cycle; // of the last time stamp
    // The identifiers of the signals in the file, one printable character each.
    char id[VCD_BOARDS][VCD_AXES][EDGE_SIGNALS];
    char clock_id;
};

// Opens the file and writes its header: for each board its name and its number of axes (VCD_BOARDS
// boards and VCD_AXES axes at most). False with errno set if the file cannot be written.
bool vcd_open(struct vcd *vcd,
              const char *path,
              int boards,
              const char *const board_names[],
              const int axes[]);

// Writes one edge. Edges must come in the order of their cycles.
void vcd_edge(struct vcd *vcd, const struct edge *edge);

// Makes the file complete up to the last edge written.
void vcd_flush(struct vcd *vcd);

// Ends the waveforms at this cycle and closes the file. False if something could not be written.
bool vcd_close(struct vcd *vcd, uint64_t end_cycle);
