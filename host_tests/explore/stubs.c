// SPDX-License-Identifier: MIT
// The simplest stand-ins for the parts of the hal that the step engine does not use. With one axis
// a round takes a millisecond; with several the part counts time.
#include "app/bus/bus_port.h"
#include "explore/part.h"
#include "hal/clock.h"
#include "hal/clock_out.h"
#include "hal/cpu.h"
#include "hal/eeprom.h"
#include "hal/pixel_clock.h"
#include "hal/switches.h"
#include "hal/uart.h"

#if CONFIG_AXES > 1
#include "avr/hal/clock_units.h" // clock_overflows

volatile uint32_t clock_overflows;

uint32_t clock_now_units(void)
{
    return part.now_ticks / CLOCK_UNIT_TICKS;
}
#else
#define UNITS_OF_MS 256u // nearly, at the 16 MHz of the Uno

static uint32_t now_units;

void scene_pass_ms(void);
void scene_pass_ms(void)
{
    now_units += UNITS_OF_MS;
}

uint32_t clock_now_units(void)
{
    return now_units;
}
#endif

#if CONFIG_AXES > 1
bool bus_port_brings_data(void)
{
    return false;
}
#endif

uint16_t uart_age_units(void)
{
    return 0;
}

uint8_t cpu_reset_cause(void)
{
    return 1;
}

#if FEATURE_CLOCK_OUT
void clock_out_set(uint16_t hz)
{
    (void)hz;
}
#endif

void cpu_watchdog_start(void)
{
}

void cpu_watchdog_feed(void)
{
}

bool cpu_stack_intact(void)
{
    return true;
}

void cpu_section(enum cpu_section section)
{
    (void)section;
}

bool eeprom_busy(void)
{
    return false;
}

uint8_t eeprom_read(uint16_t address)
{
    (void)address;
    return 0xFF;
}

void eeprom_write(uint16_t address, uint8_t byte)
{
    (void)address;
    (void)byte;
}

uint8_t switches_read(uint8_t axis)
{
    (void)axis;
    return SWITCH_ALL;
}

void switch_capture_start(uint8_t axis, bool to_high)
{
    (void)axis;
    (void)to_high;
}

void switch_capture_stop(void)
{
}

bool switch_capture_waiting(void)
{
    return false;
}

bool switch_capture_take(struct switch_capture *capture)
{
    (void)capture;
    return false;
}

#if CONFIG_AXES == 1
// Captures are not explored.
bool pixel_clock_waiting(void)
{
    return false;
}

bool pixel_clock_take(struct pixel_capture *capture)
{
    (void)capture;
    return false;
}

bool pixel_clock_any_lost(void)
{
    return false;
}

uint8_t pixel_clock_take_lost(void)
{
    return 0;
}

bool pixel_clock_take_crowded(void)
{
    return false;
}

bool pixel_clock_drop(void)
{
    return false;
}
#endif
