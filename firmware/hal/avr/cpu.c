// SPDX-License-Identifier: MIT
#include "hal/cpu.h"

#include <avr/interrupt.h>
#include <avr/io.h>

static uint8_t reset_cause;
static uint8_t address_strap;

void cpu_start(void)
{
    address_strap = GPIOR2;
    reset_cause = (uint8_t)(MCUSR & 0x0Fu);
    // A watchdog that caused the reset runs on, and would fire again in a few milliseconds.
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
