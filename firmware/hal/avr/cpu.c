// SPDX-License-Identifier: MIT
#include "hal/cpu.h"

#include <avr/interrupt.h>
#include <avr/io.h>

static uint8_t reset_cause;
static uint8_t address_strap;

// Before main and after .bss is cleared: a watchdog that caused the reset would fire again, and the general purpose
// registers get their other meanings later.
static void __attribute__((naked, used, section(".init5"))) read_reset_state(void)
{
    address_strap = GPIOR2;
    reset_cause = (uint8_t)(MCUSR & 0x0Fu);
    MCUSR = 0;
    WDTCSR = (uint8_t)(_BV(WDCE) | _BV(WDE));
    WDTCSR = 0;
}

void cpu_start_interrupts(void)
{
    sei();
}

uint8_t cpu_reset_cause(void)
{
    return reset_cause;
}

uint8_t cpu_address_strap(void)
{
    return address_strap;
}

void cpu_section(enum cpu_section section)
{
    GPIOR1 = (uint8_t)section;
}
