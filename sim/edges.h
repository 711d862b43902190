// SPDX-License-Identifier: MIT
//
// Collects every edge with its exact cycle, and writes the edges in the order of their cycles to a
// CSV file and to the file of waveforms.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "edge.h"
#include "row_queue.h"
#include "vcd.h"

struct edges {
    struct row_queue waiting; // struct edge
    FILE *csv;                // cycle,board,axis,signal,level; NULL for none
    struct vcd *vcd;          // NULL for none
};

// Opens the CSV file (NULL: none). False with errno set if it cannot be written. `vcd` is open, or
// NULL for none, and stays its owner's to close.
bool edges_open(struct edges *edges, const char *csv_path, struct vcd *vcd);

// Adds an edge, which may be some cycles earlier than others.
void edges_add(struct edges *edges, const struct edge *edge);

// No edge up to and including this cycle can still come: writes them, in the order of their cycles.
void edges_settle(struct edges *edges, uint64_t cycle);

// Makes the files complete up to the last settled cycle.
void edges_flush(struct edges *edges);

// Settles everything and closes the CSV file. False if something could not be written.
bool edges_close(struct edges *edges);
