// SPDX-License-Identifier: MIT
// What the parts of the fake board have to do with each other; suites use fakes/board.h.
#pragma once

#include <stdbool.h>
#include <stdint.h>

void fake_timers_power_on(void);

// Serve every step interrupt up to this instant, included.
void fake_timers_pass_to(uint32_t now_ticks);

// Start of the period before the newest loaded one: the running one.
uint32_t fake_timers_period_start(uint8_t axis);

void fake_pixel_clock_power_on(void);

// When the next edge is captured; false: never.
bool fake_pixel_clock_due(uint32_t *ticks);
void fake_pixel_clock_capture(void);

void fake_switches_power_on(void);

void fake_uart_power_on(void);

void fake_estop_power_on(void);
