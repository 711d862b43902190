// SPDX-License-Identifier: MIT

#include "edge.h"

const char *edge_signal_name(unsigned signal)
{
    static const char *const names[EDGE_SIGNALS] = {
        "STEP", "DIR", "ENABLE", "PERMIT", "CLOCK_OUT", "CLOCK"};

    return names[signal];
}
