// SPDX-License-Identifier: MIT
//
// Which signal of a board is on which pin: the same tables that the firmware is built from.
#pragma once

#include "board_kind.h"

#define BOARD_AXES BOARD_KIND_AXES

// NULL if there is no such board.
const struct board_kind *board_kind_by_name(const char *name);

// Names of all boards, for messages.
const char *board_kind_names(void);

// The pin of a signal, NULL if the board has none.
const struct board_pin *board_kind_pin(const struct board_kind *kind,
                                       enum board_signal signal,
                                       unsigned axis);
