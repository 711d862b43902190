// SPDX-License-Identifier: MIT
// APART: stays a function of its own. Inlined at its one call it would take more registers than
// there are, and what is then kept in memory costs more than the call. By size, measured.
#pragma once

#define APART __attribute__((noinline))
