// SPDX-License-Identifier: MIT
// What a fuzzer calls: libFuzzer's name for it.
#pragma once

#include <stddef.h>
#include <stdint.h>

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
