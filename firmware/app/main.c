// SPDX-License-Identifier: MIT
#include "app/axes/axes.h"         // axes_first_moving
#include "app/board.h"             // board_start
#include "app/bus/bus_port.h"      // bus_port_*
#include "app/round.h"             // round_poll
#include "app/settings/settings.h" // settings_override_address
#include "app/watch/safety.h"      // safety_start
#include "app/watch/time_check.h"  // time_check_start
#include "base/interlude.h"        // interlude
#include "hal/clock.h"             // clock_start
#include "hal/cpu.h"               // cpu_*
#include "hal/pins.h"              // pins_start

#if SEVERAL_AXES
// In the middle of a request.
void interlude(void)
{
    if (axes_first_moving() != NO_AXIS) {
        round_poll_briefly();
        cpu_section(CPU_SECTION_SERIAL);
    }
}
#endif

int main(void)
{
    cpu_start();
    pins_start();
    board_start();
    settings_override_address(cpu_address_strap());
    bus_port_start();
    // Start these last: from here on both timers must be served, the step timers in every period.
    clock_start();
    time_check_start();
    cpu_start_interrupts();
    safety_start();
    for (;;) {
        round_poll();
        cpu_section(CPU_SECTION_SERIAL);
        bus_port_poll();
    }
}
