// SPDX-License-Identifier: MIT
//
// The Modbus master's side of the serial bus: a request out, its answer back.
#pragma once

#include "bench.h"

// Sends the request as soon as the master's transmitter is free, and runs the bench until 1750 us
// of silence follow the answer, or until no answer has begun within `timeout_cycles` after the
// request. Bytes that were received before the request are dropped, and so are bytes of the answer
// beyond `room`. *received bytes are then in `answer`, which may be the same array as `request`.
// False if a board has stopped.
bool exchange(struct bench *bench,
              const uint8_t *request,
              size_t count,
              uint64_t timeout_cycles,
              uint8_t *answer,
              size_t room,
              size_t *received);
