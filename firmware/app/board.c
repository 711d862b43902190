// SPDX-License-Identifier: MIT
#include "app/board.h"

#include "app/axes.h"   // axes_start
#include "app/limits.h" // limits_apply_settings
#include "app/seek.h"   // seek_start
#include "app/store.h"  // store_load

void board_start(void)
{
    store_load();
    seek_start();
    axes_start();
    limits_apply_settings();
}
