// SPDX-License-Identifier: MIT
// The firmware's objects and the host's requests, for scenarios, actions and what is reported.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "app/axes/axes.h"          // axes_get
#include "app/axes/faults.h"        // faults_record
#include "app/axes/limits.h"        // limits_apply_settings
#include "app/registers/commands.h" // enum command
#include "app/settings/settings.h"  // settings_now
#include "line/segment.h"           // struct segment
#include "ring/step_engine.h"       // struct step_engine
#include "ring/step_ring.h"         // struct step_ring

extern struct step_engine step_engines[CONFIG_AXES];
extern struct step_ring step_rings[CONFIG_AXES];

static inline struct axis *scene_axis(void)
{
    return axes_get(0);
}

static inline const struct step_engine *scene_engine(void)
{
    return &step_engines[0];
}

void scene_pass_ms(void);
void scene_pixel_hz(uint16_t hz);

// As the host writes them; false when they are refused.
bool scene_order(uint16_t command, uint16_t argument);
bool scene_block(const struct segment *segments, uint8_t count);

// Armed, the axis may make edges.
bool scene_arm(uint16_t token);
// A hand at the emergency stop.
void scene_press(bool pressed);
// Periods until it is so; false if it never is.
bool scene_pass_until(bool (*there)(void));

#define BLOCK(...)                                                                       \
    scene_block((const struct segment[]){__VA_ARGS__},                                   \
                (uint8_t)(sizeof((const struct segment[]){__VA_ARGS__}) /                \
                          sizeof(struct segment)))
#define START(flags) {(int16_t)(LINE_MARK_START | (flags)), 0}, {0, 0}
#define END          {LINE_MARK_END, 0}

#define SCENE_TOKEN       7u
#define SCENE_OTHER_TOKEN 8u
