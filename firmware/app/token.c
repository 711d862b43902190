// SPDX-License-Identifier: MIT
#include "app/token.h"

#if FEATURE_TOKENS

static uint16_t held_token;
static uint16_t named_edge;
static bool edge_named;
#if FEATURE_GATE
static bool named_by_gate;
#endif

uint16_t token_now(void)
{
    return held_token;
}

void token_set(uint16_t token)
{
    held_token = token;
    edge_named = false;
}

void token_name_edge(uint16_t edge)
{
    held_token = 0;
    named_edge = edge;
    edge_named = true;
#if FEATURE_GATE
    named_by_gate = false;
#endif
}

#if FEATURE_GATE
void token_gate_edge(uint16_t edge)
{
    token_name_edge(edge);
    named_by_gate = true;
}

bool token_edge_by_gate(void)
{
    return edge_named && named_by_gate;
}
#endif

bool token_edge_named(void)
{
    return edge_named;
}

uint16_t token_edge(void)
{
    return named_edge;
}

#endif
