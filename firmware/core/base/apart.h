// SPDX-License-Identifier: MIT
// APART: stays a function of its own. Inlined at its one call it would take more registers than
// there are, and what is then kept in memory costs more than the call. Or what it keeps on the
// stack would lie below everything else that its caller calls. By size and stack, measured.
//
//     #include "base/apart.h"
//     static APART void rarely(void) ...
#pragma once

#define APART __attribute__((noinline))
