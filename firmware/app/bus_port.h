// SPDX-License-Identifier: MIT
// The serial line's side of the Modbus server: frames in, silence, replies out. Main loop only.
#pragma once

// After the settings.
void bus_port_start(void);
void bus_port_poll(void);
