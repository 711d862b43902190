// SPDX-License-Identifier: MIT
// Accounts for pixels that were written into the stream as a whole: where the pixel clock runs at
// kilohertz this is nearly all that the account has to do, so that it is assembly on a board. Main
// loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct ledger;
struct stream;

// Account for the pixels that the interrupt has made up to slot `tail`, and for their edges.
// Returns true when it is inside such a pixel now. Only outside a train.
bool ledger_take_pixels(struct ledger *ledger, struct stream *stream, uint8_t tail);
