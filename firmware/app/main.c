// SPDX-License-Identifier: MIT
#include "app/machine.h"    // machine_*
#include "app/serial.h"     // serial_*
#include "hal/clock.h"      // clock_start
#include "hal/cpu.h"        // cpu_*
#include "hal/pins.h"       // pins_start
#include "hal/step_timer.h" // step_timer_start

int main(void)
{
    cpu_start();
    pins_start();
    clock_start();
    machine_init();
    serial_start(cpu_address_strap());
    // Last: from here on the step interrupt must be served every idle period.
    step_timer_start();
    cpu_start_interrupts();
    for (;;) {
        machine_poll();
        cpu_section(CPU_SECTION_SERIAL);
        serial_poll();
        cpu_section(CPU_SECTION_IDLE);
    }
}
