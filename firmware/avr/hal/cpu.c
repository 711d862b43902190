// SPDX-License-Identifier: MIT
#include "hal/cpu.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/wdt.h>

// A known word at the lower end of the stack's room, which the linker puts behind the program's
// data. A stack that grows too far overwrites it.
#define CANARY 0xC5A3u
extern volatile uint16_t canary __asm__("__heap_start");

static uint8_t reset_cause;
static uint8_t address_strap;

void cpu_start(void)
{
    address_strap = GPIOR2;
    GPIOR0 = 0; // avr/hal/flag_bits.h; a boot loader may have used it
    reset_cause = (uint8_t)(MCUSR & 0x0Fu);
    // A watchdog that has caused the reset keeps running and would fire again in a few
    // milliseconds.
    MCUSR = 0;
    WDTCSR = (uint8_t)(_BV(WDCE) | _BV(WDE));
    WDTCSR = 0;
    canary = CANARY;
}

void cpu_watchdog_start(void)
{
    wdt_enable(WDTO_120MS);
}

void cpu_watchdog_feed(void)
{
    wdt_reset();
}

bool cpu_stack_intact(void)
{
    return canary == CANARY;
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
