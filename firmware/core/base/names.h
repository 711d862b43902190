// SPDX-License-Identifier: MIT
// The codes of faults.def and line_errors.def as C enumerations.
//
//     faults.def        FAULT(code, name, ...)       FAULT_name, docs/FAULTS.md
//     line_errors.def   LINE_ERROR(code, name, ...)  LINE_name
//
// The codes are part of the protocol, because hosts read them in registers: a code never changes
// its meaning. The other columns of the rows are for the documents and the host tools.
//
// Every code fits 8 bits, and the firmware keeps codes in a uint8_t. 0 stands for no fault, and for
// no error.
#pragma once

#define FAULT(code, name, ...) FAULT_##name = (code),
// Why the board stopped its axes; FAULT_none is 0.
enum fault {
#include "base/faults.def"
};
#undef FAULT

#define LINE_ERROR(code, name, ...) LINE_##name = (code),
// Why a line was refused, or (from 32 on) why the host was warned about a line.
enum line_error {
#include "base/line_errors.def"
};
#undef LINE_ERROR
