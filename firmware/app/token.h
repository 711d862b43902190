// SPDX-License-Identifier: MIT
// The start token: axes that were armed with a token wait until command `go` names it, so that
// several boards can start on the same pixel clock edge. One token at a time. Main loop only.
//
//     board 1   arm, token 7 ---- waits ----+           +-- both start on the next clock edge
//     board 2   arm, token 7 -- waits --+   |           |
//     host                              go 7 to all ----+
//
// A token is held by the board, not by an axis. An image without FEATURE_TOKENS holds none.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h" // FEATURE_TOKENS

#if FEATURE_TOKENS

// The token (1..65535) that armed axes wait for; 0: they wait for none.
uint16_t token_now(void);
// Hold armed axes back until command `go` names this token; 0: release them.
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
