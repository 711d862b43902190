// SPDX-License-Identifier: MIT
// What passed on the bus: the server's counters and the time of the last request. Main loop only.
#pragma once

#include <stdint.h>

#include "wire/server.h" // struct server_counters

void traffic_start(void);

// For the server and the bus port, which count in place.
struct server_counters *traffic_counters(void);

// Bytes that the receiver lost.
void traffic_count_overruns(uint8_t bytes);

// A request for this board, or for all, is being served.
void traffic_note_request(void);

// When that was last, as clock_now_ms().
uint16_t traffic_last_request_ms(void);
