// SPDX-License-Identifier: MIT
// The serial line: bytes in through a small ring, replies out from the caller's buffer, the RS-485
// driver enabled exactly while sending.
#pragma once

#include <stdbool.h>
#include <stdint.h>

void uart_start(void);

// Oldest received byte; false when there is none.
bool uart_take(uint8_t *byte);

// Bytes lost since the last call.
uint8_t uart_take_overruns(void);

// Send length bytes (1..256); the buffer must stay until uart_sending() is false.
void uart_send(const uint8_t *bytes, uint16_t length);

// True until the last stop bit has left.
bool uart_sending(void);
