// SPDX-License-Identifier: MIT
// The account from waypoint to waypoint (ledger.h): nearly all of its work where the pixel clock
// runs at kilohertz. The AVR therefore has these functions in assembly (avr/core); the C that the
// assembly stands for is ledger_waypoints.c. Main loop only.
//
//     stream      | retired | p | p | p | p | p | p | p | ... tail
//     waypoints             edge        ^           ^ next: not reached yet
//                           passed by its slot, its time and its position alone
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "account/ledger_data.h" // struct ledger
#include "stream/stream.h"       // struct stream

// `count` single periods, 0..252, were passed: count their steps, if they pulse, and remember how
// many of them, up to three, can still be read from the ring.
void ledger_pass_periods(struct ledger *ledger, uint8_t count);

// The edge of the line's next pixel was passed: write its record. position_steps: position of the
// axis at the edge, signed steps. expected_steps: expected position in the line, low 16 bits.
void ledger_pass_edge(struct ledger *ledger,
                      int32_t position_steps,
                      uint16_t expected_steps);

// Pass the waypoints that single periods alone lead to, up to slot `tail`, where the interrupt
// reads next: time is what the waypoint tells, and steps are counted by the slots. Returns true
// when the interrupt is on such a way now (stream_on_plain_way()). Only outside a train. The time
// that the assembly takes grows with the waypoints, not with the periods.
bool ledger_pass_waypoints(struct ledger *ledger, struct stream *stream, uint8_t tail);
