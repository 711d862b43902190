// SPDX-License-Identifier: MIT
#include "app/machine.h" // machine_*
#include "app/serial.h"  // serial_*
#include "hal/clock.h"   // clock_start
#include "hal/cpu.h"     // cpu_*
#include "hal/pins.h"    // pins_start

int main(void)
{
    pins_start();
    clock_start();
    machine_init();
    serial_start(cpu_address_strap());
    cpu_start_interrupts();
    for (;;) {
        machine_poll();
        cpu_section(CPU_SECTION_SERIAL);
        serial_poll();
        cpu_section(CPU_SECTION_IDLE);
    }
}
