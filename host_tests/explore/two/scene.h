// SPDX-License-Identifier: MIT
// The firmware's objects and the host's requests, for scenarios, actions and what is reported.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "app/axes/axes.h"          // axes_get
#include "app/axes/faults.h"        // faults_record
#include "app/registers/commands.h" // enum command
#include "avr/hal/step_isr.h"       // step_engines, step_rings
#include "explore/two/judged.h"     // enum line_kind
#include "line/segment.h"           // struct segment

#define BOTH              0x3u
#define SCENE_TOKEN       7u
#define SCENE_OTHER_TOKEN 8u

// The clock's edges and a line's pixels, at the 20 MHz of the board.
#define PIXEL_HZ    500u
#define PIXEL_TICKS (CONFIG_TIMER_HZ / PIXEL_HZ)

// What the judge knows of a line.
struct line_plan {
    const struct segment *pixels; // one each
    uint8_t count;
    uint8_t steps;
};

const struct line_plan *scene_plan(uint8_t line);

// As the host writes them; false when they are refused. The judge is told what was accepted.
bool scene_order(uint16_t command, uint16_t mask, uint16_t argument);
bool scene_arm(uint16_t mask, uint16_t token);
bool scene_go(uint16_t token);
// flags: of the start mark.
bool scene_line(uint8_t axis, enum line_kind line, uint16_t flags);
bool scene_refused_block(uint8_t axis);
void scene_sync(uint16_t sync); // with a clock that runs, unless it is ignored

// A hand at the emergency stop.
void scene_press(bool pressed);
// Periods until it is so; false if it never is.
bool scene_pass_until(bool (*there)(void));
