// SPDX-License-Identifier: MIT
#include "app/axes/permit.h"

#include "hal/estop.h" // permit_write

static bool permit_on;

void permit_set(bool on)
{
    permit_on = on;
    permit_write(on);
}

bool permit_is_on(void)
{
    return permit_on;
}
