// SPDX-License-Identifier: MIT
// Function 20: records of files, which are registers under another name. The server calls it.
//
//     file   what it holds          record n is
//     1      the per-pixel records  input register 0x0100 + n
//     2      the event log          input register 0x0300 + n
//     3      the settings           holding register n
//
//     request    count | 6, file, record, words | 6, file, record, words | ...
//     reply      count | length, 6, words...    | length, 6, words...    | ...
//
// A request may name several pieces of several files, and all of them are read or none. Reading a
// record changes nothing. Main loop only; in images with FEATURE_FILES only.
#pragma once

#include "wire/frame.h"       // struct frame
#include "wire/server_data.h" // enum modbus_exception

// Replace the request in frame->bytes by its reply and set frame->reply to the reply's length,
// bytes without the checksum. The caller has checked that the frame is as long as its byte count
// says. Returns MODBUS_OK. Returns MODBUS_ILLEGAL_VALUE when a count is wrong or the reply would
// not fit one frame, and MODBUS_ILLEGAL_ADDRESS when a file or one of its records does not exist;
// the request is then unchanged.
enum modbus_exception files_read(struct frame *frame);
