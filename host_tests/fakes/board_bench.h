// SPDX-License-Identifier: MIT
// The machine on the fake board, and lines queued through the register map as a host does
// it.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "app/axes/axes.h"          // axes_get
#include "app/axes/faults.h"        // faults_*
#include "app/axes/limits.h"        // limits_*
#include "app/axes/permit.h"        // permit_is_on
#include "app/axes/reference.h"     // reference_*
#include "app/axes/token.h"         // token_now
#include "app/motion/seek.h"        // seek_*
#include "app/registers/commands.h" // enum command
#include "app/settings/settings.h"  // settings_now
#include "config.h"                 // CONFIG_AXES
#include "wire/server_data.h"       // enum modbus_exception

// A round of the main loop in ticks.
#define BENCH_ROUND_TICKS 1500u

// Rounds that are enough for any line of the suites.
#define BENCH_ROUNDS_MAX 30000u

// Pixel frequency of the bench, 1000 Hz at 16 MHz: a pixel has the same ticks on every board.
#define BENCH_PIXEL_HZ    ((uint16_t)(CONFIG_TIMER_HZ / BENCH_PIXEL_TICKS))
#define BENCH_SLOW_HZ     (BENCH_PIXEL_HZ / 10u)
#define BENCH_PIXEL_TICKS 16000u

// Axes that a suite takes on every board: of two, the first stands in for the second (where the
// suite wants another than the pixel clock's) and for the third, the second for the last.
#if CONFIG_AXES > 2
#define BENCH_SECOND 1u
#define BENCH_THIRD  2u
#else
#define BENCH_SECOND 0u
#define BENCH_THIRD  0u
#endif
#define BENCH_LAST          (CONFIG_AXES - 1u)
#define BENCH_MASK_OF(axis) ((uint16_t)(1u << (axis)))
#define BENCH_ALL_AXES      ((uint16_t)((1u << CONFIG_AXES) - 1u))

#define BENCH_TICKS_PER_MS ((uint32_t)(CONFIG_TIMER_HZ / 1000uL))

// Power on, settings for BENCH_PIXEL_HZ, the pixel clock running since tick 5000.
void bench_power_on(void);

// The settings, to be changed without a host; limits_apply_settings() may have to follow.
struct settings *bench_settings(void);

// Number of a clock edge so many edges ahead, as `go` names it.
uint16_t bench_edge_ahead(uint16_t edges);

// Edges from `go` to line zero.
#define BENCH_GO_EDGES 20u

// An order in one call; `go` names an edge BENCH_GO_EDGES ahead.
bool bench_give(uint8_t mask, enum command command, uint16_t argument);

// Mask of the axes in this state.
uint8_t bench_axes_in(enum axis_state state);

void bench_clock_on(void);
void bench_clock_off(void);

// Rounds: time passes, then round_poll().
void bench_rounds(uint16_t rounds);

// Rounds until the axis is in this state; false: never.
bool bench_until(uint8_t axis, enum axis_state state);

// One entry through the queue window.
enum modbus_exception bench_entry(uint8_t axis, int16_t count, uint16_t repeat);

// A whole plain line that waits for the pixel clock: `pixels` of `count` steps each.
void bench_plain_line(uint8_t axis, int16_t count, uint16_t pixels);

// A plain line without its end: enough to be armed, not enough to be finished. Its steps.
int32_t bench_long_start(uint8_t axis);

// Axis mask and command in one write.
enum modbus_exception bench_command(uint16_t mask, enum command command);

uint16_t bench_input(uint16_t address);
uint32_t bench_input_wide(uint16_t address);
