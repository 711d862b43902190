// SPDX-License-Identifier: MIT
// Function 20: records of files, which are registers under another name. File 1 are the per-pixel
// records (record n is input register 0x0100 + n), file 2 is the event log (input register
// 0x0300 + n), file 3 the settings (holding register n).
#pragma once

#include "wire/frame.h"       // struct frame
#include "wire/server_data.h" // enum modbus_exception

// The request in the frame becomes its reply. Its length is right.
enum modbus_exception files_read(struct frame *frame);
