// SPDX-License-Identifier: MIT
// REQUIRE(): a promise inside the firmware. Broken, it becomes the named fault `internal` with the
// source line as argument. REQUIRE() is never for mistakes of a host or of the hardware.
#pragma once

#include <stdint.h>

#define REQUIRE(promise)                                                                 \
    do {                                                                                 \
        if (!(promise)) {                                                                \
            require_failed((uint16_t)__LINE__);                                          \
        }                                                                                \
    } while (0)

// Supplied by who links core: the firmware raises the fault, a test fails. May return.
void require_failed(uint16_t line);
