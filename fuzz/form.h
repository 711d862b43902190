// SPDX-License-Identifier: MIT
// The form of a reply, whatever was asked of whom: address, function, length, checksum.
#pragma once

#include <stdint.h>

// The request was for one board; the reply has its checksum. Fails when the reply cannot be one to
// it.
void form_check(const uint8_t *request, const uint8_t *reply, uint16_t reply_count);
