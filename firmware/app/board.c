// SPDX-License-Identifier: MIT
#include "app/board.h"

#include "app/axes/axes.h"      // axes_start
#include "app/axes/limits.h"    // limits_apply_settings
#include "app/motion/seek.h"    // seek_start
#include "app/settings/store.h" // store_load

void board_start(void)
{
    store_load();
    seek_start();
    axes_start();
    limits_apply_settings();
}
