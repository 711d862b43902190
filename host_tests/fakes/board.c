// SPDX-License-Identifier: MIT
// Fakes of time and of the simple contracts: clock, cpu, pins.
#include "fakes/board.h"

#include "fakes/board_parts.h"
#include "hal/clock.h"
#include "hal/cpu.h"
#include "hal/pins.h"

uint8_t fake_reset_cause = 0x02;
bool fake_stack_intact = true;
uint16_t fake_watchdog_feeds;

static uint32_t now_ticks;
static uint32_t section_ticks; // that pass with each section of the main loop

void fake_power_on(void)
{
    now_ticks = 0;
    section_ticks = 0;
    fake_timers_power_on();
    fake_pixel_clock_power_on();
    fake_switches_power_on();
    fake_uart_power_on();
    fake_estop_power_on();
    fake_reset_cause = 0x02;
    fake_stack_intact = true;
    fake_watchdog_feeds = 0;
}

uint32_t fake_now_ticks(void)
{
    return now_ticks;
}

void fake_pass(uint32_t ticks)
{
    uint32_t end_ticks = now_ticks + ticks;
    uint32_t due_ticks = 0;

    while (fake_pixel_clock_due(&due_ticks) && (int32_t)(due_ticks - end_ticks) <= 0) {
        now_ticks = due_ticks;
        fake_timers_pass_to(now_ticks);
        fake_pixel_clock_capture();
    }
    now_ticks = end_ticks;
    fake_timers_pass_to(now_ticks);
}

void clock_start(void)
{
}

uint32_t clock_now_units(void)
{
    return now_ticks / CLOCK_UNIT_TICKS;
}

void cpu_start_interrupts(void)
{
}

uint8_t cpu_reset_cause(void)
{
    return fake_reset_cause;
}

void cpu_watchdog_start(void)
{
}

void cpu_watchdog_feed(void)
{
    fake_watchdog_feeds++;
}

bool cpu_stack_intact(void)
{
    return fake_stack_intact;
}

uint8_t cpu_address_strap(void)
{
    return 0;
}

void fake_slow_sections(uint32_t ticks)
{
    section_ticks = ticks;
}

void cpu_section(enum cpu_section section)
{
    (void)section;
    fake_pass(section_ticks);
}

void pins_start(void)
{
}
