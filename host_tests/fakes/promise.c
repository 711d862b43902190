// SPDX-License-Identifier: MIT
#include "fakes/promise.h"

#include "base/require.h" // require_failed

uint16_t promise_broken;

// Weak, so that a suite that links app gets the function of app.
__attribute__((weak)) void require_failed(uint16_t line)
{
    promise_broken = line;
}
