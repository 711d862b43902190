// SPDX-License-Identifier: MIT
// The form of a reply, whatever was asked of whom: address, function, length, checksum.
#pragma once

#include <stdint.h>

// Both with their checksums; the request was for one board. Fails when the reply cannot be one to
// it.
void form_check(const uint8_t *request,
                uint16_t request_count,
                const uint8_t *reply,
                uint16_t reply_count);
