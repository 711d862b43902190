// SPDX-License-Identifier: MIT
// The start token: axes armed with one are held back until command `go` names it, so that several
// boards can start on the same pixel clock edge. One token at a time. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_TOKENS

#if FEATURE_TOKENS

uint16_t token_now(void); // 0: nothing is held back
void token_set(uint16_t token);

#else

static inline uint16_t token_now(void)
{
    return 0;
}

static inline void token_set(uint16_t token)
{
    (void)token;
}

#endif
