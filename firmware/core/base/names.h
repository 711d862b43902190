// SPDX-License-Identifier: MIT
// The codes of faults.def and line_errors.def as C enumerations.
#pragma once

#define FAULT(code, name, ...) FAULT_##name = (code),
enum fault {
#include "base/faults.def"
};
#undef FAULT

#define LINE_ERROR(code, name, ...) LINE_##name = (code),
enum line_error {
#include "motion/line_errors.def"
};
#undef LINE_ERROR
