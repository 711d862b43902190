// SPDX-License-Identifier: MIT
#include "app/token.h"

#if FEATURE_TOKENS

static uint16_t now;

uint16_t token_now(void)
{
    return now;
}

void token_set(uint16_t token)
{
    now = token;
}

#endif
