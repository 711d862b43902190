// SPDX-License-Identifier: MIT
// The serial line's side of the Modbus server: frames in, silence, replies out. Main loop only.
#pragma once

#include <stdint.h>

#include "wire/server.h" // struct server_counters

// address: 0 keeps the address setting, else overrides it (the board's strap). After the settings.
void serial_start(uint8_t address);
void serial_poll(void);

const struct server_counters *serial_counters(void);

// When a request for this board, or for all, was served last, as clock_now_ms().
uint16_t serial_last_request_ms(void);
