// SPDX-License-Identifier: MIT
// The start token, and the clock edge that `go` names: axes that were armed with a token wait until
// command `go` carries it, and then for that edge. So several boards begin on one edge of their
// common pixel clock, whatever each of them has still to do. One token at a time. Main loop only.
//
//     board 1   arm, token 7 ---- ready ----+           +------------+-- line zero: edge 5310
//     board 2   arm, token 7 -- ready --+   |           |       +----|-- line zero: edge 481
//     host                              go 7, 481   go 7, 5310  ^    ^ the same edge of the clock,
//                                                                each by its own board's count
//
// A token is held by the board, not by an axis. An image without FEATURE_TOKENS holds none.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_TOKENS, FEATURE_GATE

#if FEATURE_TOKENS

// The token (1..65535) that armed axes wait for; 0: they wait for none.
uint16_t token_now(void);
// True while there is one,
bool token_held(void);
// and while it is this one, or, of 0, while there is none. Not while an edge is named.
bool token_is(uint16_t token);
// Hold armed axes back until command `go` brings this token; 0: release them. No edge is named.
void token_set(uint16_t token);

// Release armed axes; line zero is the clock edge of this number (reference_number()).
void token_name_edge(uint16_t edge);
// True from token_name_edge() to the next token_set().
bool token_edge_named(void);
// The number of the named edge.
uint16_t token_edge(void);

#else

static inline uint16_t token_now(void)
{
    return 0;
}

static inline bool token_held(void)
{
    return false;
}

static inline bool token_is(uint16_t token)
{
    return token == 0;
}

static inline void token_set(uint16_t token)
{
    (void)token;
}

static inline bool token_edge_named(void)
{
    return false;
}

static inline uint16_t token_edge(void)
{
    return 0;
}

#endif

#if FEATURE_GATE
// Lines that are armed, or will be in time, begin on the clock edge of this number: the first edge
// of a burst has come (gate.h).
void token_gate_edge(uint16_t edge);
// True from token_gate_edge() to the next token_set() or token_name_edge().
bool token_edge_by_gate(void);
#else
static inline bool token_edge_by_gate(void)
{
    return false;
}
#endif
