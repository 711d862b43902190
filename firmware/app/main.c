// SPDX-License-Identifier: MIT
#include "app/machine.h"    // machine_init
#include "app/round.h"      // round_poll
#include "app/safety.h"     // safety_start
#include "app/serial.h"     // serial_*
#include "app/time_check.h" // time_check_start
#include "hal/clock.h"      // clock_start
#include "hal/cpu.h"        // cpu_*
#include "hal/pins.h"       // pins_start

int main(void)
{
    cpu_start();
    pins_start();
    machine_init();
    serial_start(cpu_address_strap());
    // Last: from here on both must be served, the step interrupt in every idle period.
    clock_start();
    time_check_start();
    cpu_start_interrupts();
    safety_start();
    for (;;) {
        round_poll();
        cpu_section(CPU_SECTION_SERIAL);
        serial_poll();
    }
}
