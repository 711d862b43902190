// SPDX-License-Identifier: MIT
#include "app/axes/token.h"

#if FEATURE_TOKENS

enum awaited {
    AWAITED_NOTHING,
    AWAITED_TOKEN,
    AWAITED_EDGE,
    AWAITED_EDGE_OF_GATE,
};

static uint8_t awaited;
static uint16_t number; // of the token, or of the edge

bool token_held(void)
{
    return awaited == AWAITED_TOKEN;
}

uint16_t token_now(void)
{
    return token_held() ? number : 0;
}

bool token_is(uint16_t token)
{
    return number == token;
}

void token_set(uint16_t token)
{
    number = token;
    awaited = token != 0 ? AWAITED_TOKEN : AWAITED_NOTHING;
}

void token_name_edge(uint16_t edge)
{
    number = edge;
    awaited = AWAITED_EDGE;
}

bool token_edge_named(void)
{
    return awaited >= AWAITED_EDGE;
}

uint16_t token_edge(void)
{
    return number;
}

#if FEATURE_GATE
void token_gate_edge(uint16_t edge)
{
    number = edge;
    awaited = AWAITED_EDGE_OF_GATE;
}

bool token_edge_by_gate(void)
{
    return awaited == AWAITED_EDGE_OF_GATE;
}
#endif

#endif
