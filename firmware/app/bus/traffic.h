// SPDX-License-Identifier: MIT
// What passed on the bus: the server's counters, and the time of the last request. Main loop only.
// The counters show a host how healthy the bus is (function 08 and input registers); the time lets
// app/watch/safety.h stop the board when the bus falls silent.
#pragma once

#include <stdint.h>

#include "wire/server.h" // struct server_counters

// Counters 0; the bus time-out begins now.
void traffic_start(void);

// The counters, for everybody who counts or reads them: the server and the bus port increment them
// in place. They wrap, and function 08 can clear them.
struct server_counters *traffic_counters(void);

// Add this number of bytes that the receiver lost to the counter rx_overruns.
void traffic_count_overruns(uint8_t bytes);

// A request to this board, or to all boards, is being served: the bus time-out begins again. Not
// called in listen-only mode, in which no request is executed.
void traffic_note_request(void);

// Time of the last such request, as clock_now_ms(), which wraps after 65 s.
uint16_t traffic_last_request_ms(void);
