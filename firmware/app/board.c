// SPDX-License-Identifier: MIT
#include "app/board.h"

#include "app/axes.h"    // axes_start
#include "app/drivers.h" // drivers_start
#include "app/events.h"  // events_start
#include "app/faults.h"  // faults_start
#include "app/inputs.h"  // inputs_start
#include "app/limits.h"  // limits_apply_settings
#include "app/permit.h"  // permit_set
#include "app/seek.h"    // seek_start
#include "app/store.h"   // store_load
#include "app/token.h"   // token_set
#include "app/traffic.h" // traffic_start

void board_start(void)
{
    store_load();
    events_start();
    seek_start();
    axes_start();
    drivers_start();
    inputs_start();
    permit_set(false);
    token_set(0);
    faults_start();
    traffic_start();
    limits_apply_settings();
}
