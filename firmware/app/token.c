// SPDX-License-Identifier: MIT
#include "app/token.h"

#if FEATURE_TOKENS

static uint16_t held_token;

uint16_t token_now(void)
{
    return held_token;
}

void token_set(uint16_t token)
{
    held_token = token;
}

#endif
