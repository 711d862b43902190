// SPDX-License-Identifier: MIT
// What the standard wants of a request, worked out over a copy of the model: written apart from the
// server, straight from the rules, so that the two can be compared.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "model.h"

struct expected {
    uint8_t bytes[256]; // address and PDU of the reply
    uint16_t count;     // 0: none is to come
    bool counted;       // its last two bytes are a counter, whatever it says
};

// request: address and PDU, `count` bytes without the checksum. Changes `world` as it should be
// changed.
void reference_serve(const uint8_t *request,
                     uint16_t count,
                     struct model *world,
                     struct expected *expected);
