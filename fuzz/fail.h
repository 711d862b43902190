// SPDX-License-Identifier: MIT
// A broken promise ends the run: the fuzzer keeps the input that broke it.
#pragma once

__attribute__((noreturn, format(printf, 1, 2))) void fuzz_fail(const char *format, ...);

// Does nothing when the promise is kept.
#define PROMISE(kept, ...)                                                               \
    do {                                                                                 \
        if (!(kept)) {                                                                   \
            fuzz_fail(__VA_ARGS__);                                                      \
        }                                                                                \
    } while (0)
