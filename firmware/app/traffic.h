// SPDX-License-Identifier: MIT
// What passed on the bus: the server's counters, and the time of the last request. Main loop only.
#pragma once

#include <stdint.h>

#include "wire/server.h" // struct server_counters

// Counters 0; the bus time-out begins now.
void traffic_start(void);

// The counters, which the server and the bus port increment in place.
struct server_counters *traffic_counters(void);

// Count bytes that the receiver lost.
void traffic_count_overruns(uint8_t bytes);

// A request to this board, or to all boards, is being served.
void traffic_note_request(void);

// Time of the last such request, as clock_now_ms().
uint16_t traffic_last_request_ms(void);
