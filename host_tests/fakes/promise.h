// SPDX-License-Identifier: MIT
// Stands in for app's require_failed() in suites that need core only. Refer to
// promise_broken in such a suite: that is what makes the linker take this file before it
// comes to core.
#pragma once

#include <stdint.h>

// Line of the last broken REQUIRE(), 0: none.
extern uint16_t promise_broken;
