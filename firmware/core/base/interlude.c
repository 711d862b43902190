// SPDX-License-Identifier: MIT
#include "base/interlude.h"

// Of whoever has no axes to look after.
__attribute__((weak)) void interlude(void)
{
}

__attribute__((weak)) void interlude_of_one(bool kept)
{
    (void)kept;
}
