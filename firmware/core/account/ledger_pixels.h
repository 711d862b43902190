// SPDX-License-Identifier: MIT
// What the account does at each pixel edge, and for pixels that were written into the stream as a
// whole: where the pixel clock runs at kilohertz this is nearly all that there is to do, so that it
// is assembly on a board. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct ledger;
struct stream;

// `count` single pulsing or quiet periods were passed. The ring still holds the last three.
void ledger_pass_periods(struct ledger *ledger, uint8_t count);

// The edge of the line's next pixel was passed, at this position. expected_steps: as of
// records_add().
void ledger_pass_edge(struct ledger *ledger,
                      int32_t position_steps,
                      uint16_t expected_steps);

// Account for the pixels that the interrupt has made up to slot `tail`, and for their edges.
// Returns true when it is inside such a pixel now. Only outside a train.
bool ledger_take_pixels(struct ledger *ledger, struct stream *stream, uint8_t tail);
