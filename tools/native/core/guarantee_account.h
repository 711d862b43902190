// SPDX-License-Identifier: MIT
// The clock's edges, and the accounts that make room in the rings.
#pragma once

#include <stdbool.h>

#include "guarantee_loop.h" // struct loop

// Take the edges that wait, and no more: edges that come faster than they can be taken are lost,
// and so are those for which there is no room in the queue after the longest request.
void loop_take_edges(struct loop *r);

// True when the account of an axis finds something new.
bool loop_account_helps(const struct loop *r, const struct axis *a);

// Entries that are made and can be accounted for: those of a part are free when all of them are
// made.
double loop_made_entries(const struct loop *r, const struct axis *a);

// Advance the account of an axis. Boards of several axes look only where something is made.
void loop_advance(struct loop *r, struct axis *a);
