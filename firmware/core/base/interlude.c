// SPDX-License-Identifier: MIT
#include "base/interlude.h"

// Of whoever has no axes to look after.
__attribute__((weak)) void interlude(void)
{
}
