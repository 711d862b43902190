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
// A token is held by the board, not by an axis. An image without FEATURE_TOKENS holds none. At any
// time the board holds a token, or has an edge named, or neither:
//
//     token_set(token)          a token is held; armed axes wait for `go`
//     token_name_edge(edge)     released by `go`; lines that wait for the clock begin on this edge
//     token_gate_edge(edge)     the same, named by the first edge of a burst
//     token_set(0)              neither: armed axes begin as soon as they can
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_TOKENS, FEATURE_GATE

#if FEATURE_TOKENS

// The token (1..65535) that armed axes wait for; 0: they wait for none.
uint16_t token_now(void);
// True while a token is held.
bool token_held(void);
// True while the token that is held is this one; of 0, while none is held. Must not be asked while
// an edge is named: the result then means nothing.
bool token_is(uint16_t token);
// Hold armed axes back until command `go` brings this token; 0: release them. An edge that was
// named is named no longer.
void token_set(uint16_t token);

// Release armed axes; line zero is the clock edge of this number (reference_number()).
void token_name_edge(uint16_t edge);
// True from token_name_edge(), or from token_gate_edge(), to the next token_set().
bool token_edge_named(void);
// The number of the named edge. Only while token_edge_named().
uint16_t token_edge(void);

#else

// Without FEATURE_TOKENS no token is held and no edge is named.
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
// Without FEATURE_GATE no burst names an edge.
static inline bool token_edge_by_gate(void)
{
    return false;
}
#endif
