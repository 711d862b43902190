// SPDX-License-Identifier: MIT
#include "app/permit.h"

#include "hal/estop.h" // permit_write

static bool is_on;

void permit_set(bool on)
{
    is_on = on;
    permit_write(on);
}

bool permit_is_on(void)
{
    return is_on;
}
