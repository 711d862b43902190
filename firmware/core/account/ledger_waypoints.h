// SPDX-License-Identifier: MIT
// The account from waypoint to waypoint (ledger.h): nearly all that there is to do where the pixel
// clock runs at kilohertz, so that it is assembly on a board; the C is ledger_waypoints.c.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "account/ledger_data.h" // struct ledger
#include "stream/stream.h"       // struct stream

// `count` single pulsing or quiet periods were passed. The ring still holds the last three.
void ledger_pass_periods(struct ledger *ledger, uint8_t count);

// The edge of the line's next pixel was passed, at this position. expected_steps: as of
// records_add().
void ledger_pass_edge(struct ledger *ledger,
                      int32_t position_steps,
                      uint16_t expected_steps);

// Pass the waypoints that single periods alone lead to, up to slot `tail`, where the interrupt
// reads next: time is what the waypoint tells, steps are counted by the slots. Returns true when
// the interrupt is on such a way now (stream_on_plain_way()). Only outside a train.
bool ledger_pass_waypoints(struct ledger *ledger, struct stream *stream, uint8_t tail);
