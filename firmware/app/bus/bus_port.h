// SPDX-License-Identifier: MIT
// Connects the serial port with the Modbus server. Main loop only.
//
//     LISTENING --> REQUESTED --> ANSWERED --> SENDING --> LISTENING
//        |          waits for     waits for    until the
//        |          3.5 chars     reply_delay  last bit
//        +-- broadcast: served at once, no reply
//
// Between REQUESTED and the end of SENDING the board receives nothing.
#pragma once

#include <stdbool.h>

#include "build_features.h" // SEVERAL_AXES

// Start with the settings' rate, parity and address; after the settings were loaded.
void bus_port_start(void);
// One step of the port: a frame, the reply or its sending. Called in every round of the main loop;
// takes up to some milliseconds.
void bus_port_poll(void);

#if SEVERAL_AXES
// True when bus_port_poll() has entries of lines to take, or their reply to send: a fast line may
// run dry while the decoding for several axes makes a round long.
bool bus_port_brings_data(void);
#endif
