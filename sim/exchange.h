// SPDX-License-Identifier: MIT
//
// The Modbus master's side of the serial line: a request out, its answer back.
#pragma once

#include "bench.h"

// Sends the bytes and runs until 1750 us of silence after the answer, or until `timeout` cycles
// after the request without one. True unless a board stopped; *received bytes are in answer
// (which may be the same array as the request).
bool exchange(struct bench *bench,
              const uint8_t *request,
              size_t count,
              uint64_t timeout_cycles,
              uint8_t *answer,
              size_t room,
              size_t *received);
