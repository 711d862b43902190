// SPDX-License-Identifier: MIT
#include "app/token.h"

#if FEATURE_TOKENS

static uint16_t held_token;
static uint16_t named_edge;
static bool edge_named;

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
}

bool token_edge_named(void)
{
    return edge_named;
}

uint16_t token_edge(void)
{
    return named_edge;
}

#endif
