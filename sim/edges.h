// SPDX-License-Identifier: MIT
//
// Collects every signal edge with its exact cycle. Boards run one after the other within a
// quantum, so edges arrive out of order; at the quantum's end they are put in order and handed to
// the writers.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum edge_signal {
    EDGE_STEP,
    EDGE_DIR,
    EDGE_ENABLE,
    EDGE_PERMIT, // of the whole board: axis 0
    EDGE_CLOCK,
    EDGE_SIGNALS,
};

struct edge {
    uint64_t cycle;
    uint8_t board, axis, signal, level;
};

struct vcd;

struct edges {
    struct edge *waiting;
    size_t count, room;
    FILE *csv;       // cycle,board,axis,signal,level; NULL for none
    struct vcd *vcd; // NULL for none
};

// Opens the CSV file (NULL: none). False with errno set if it cannot be written.
bool edges_open(struct edges *edges, const char *csv_path, struct vcd *vcd);

void edges_add(struct edges *edges, const struct edge *edge);

// No edge up to and including this cycle can still come: writes them, in order of cycles.
void edges_settle(struct edges *edges, uint64_t cycle);

void edges_flush(struct edges *edges);

// Settles everything and closes the files. False if something could not be written.
bool edges_close(struct edges *edges);

const char *edge_signal_name(unsigned signal);
