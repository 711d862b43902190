// SPDX-License-Identifier: MIT
// REQUIRE(): a promise inside the firmware. Broken, it becomes the named fault `internal` with the
// source line as argument. REQUIRE() is never for mistakes of a host or of the hardware.
//
//     cause                          result
//     a host sends nonsense          exception reply, line error
//     hardware fails                 a fault of its own name
//     this program breaks a promise  REQUIRE() --> fault `internal`, argument: the line
#pragma once

#include <stdint.h>

// Check the promise where it must hold; main loop only. The condition is always evaluated, in every
// image, and must have no side effects. The statements after REQUIRE() run even after a broken
// promise, because require_failed() may return.
#define REQUIRE(promise)                                                                 \
    do {                                                                                 \
        if (!(promise)) {                                                                \
            require_failed((uint16_t)__LINE__);                                          \
        }                                                                                \
    } while (0)

// Called with the number of the source line of a broken promise; the name of the file is not told.
// Whoever links core supplies the function: the firmware latches the fault, a test fails. May
// return.
void require_failed(uint16_t line);
