// SPDX-License-Identifier: MIT
// The board's axes, each with its ring and its step timer. This module brings samples of the step
// interrupts to the accounts (account/ledger.h), and axes to rest. An edge that was captured and
// not taken holds an account back, because the edge is placed by the sample that its interrupt
// took. Main loop only.
//
//     step interrupt --> sample --> ledger        captured edge waits: no newer sample may pass it
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "axis/axis.h" // struct axis
#include "config.h"    // CONFIG_AXES

// An index that stands for no axis: the one after the last.
#define NO_AXIS CONFIG_AXES

// Mask of all axes.
#define ALL_AXES ((uint8_t)((1u << CONFIG_AXES) - 1u))

// Mask of one axis, 0..CONFIG_AXES-1.
static inline uint8_t axis_bit(uint8_t axis)
{
    return CONFIG_AXES == 1 ? 1u : (uint8_t)(1u << axis);
}

// Every axis EMPTY, at position 0. Called with interrupts off; time_check_start() must follow, and
// interrupts must be on before an idle period is over.
void axes_start(void);

// One of the axes, 0..CONFIG_AXES-1; lasts as long as the program. The functions of axis/axis.h
// change its state.
struct axis *axes_get(uint8_t axis);

// Advance an axis's account to what its step interrupt has done by now. With LEDGER_BY_WAYPOINTS
// only when the account has fallen behind far enough to be worth the time. Returns false and
// changes nothing when a captured edge must be taken first.
bool axes_advance_at(uint8_t i, enum ledger_extent extent);

// axes_advance_at(); with a single axis the compiler sees that i is 0.
static inline bool axes_advance(uint8_t i, enum ledger_extent extent)
{
    return axes_advance_at(CONFIG_INDEX(i), extent);
}

// The time of an axis by its account, ticks since the timers started: where its timer stands at
// this count of the period that its interrupt has served last. sample: taken together with the
// counter, just now. The account comes to the sample. Returns false, and the account stays, when a
// captured edge must be taken first. On boards of several axes only.
bool axes_time_at(uint8_t i,
                  const struct engine_sample *sample,
                  uint16_t counter,
                  uint32_t *ticks);

// What an axis's step interrupt has done by now; the axis's account is advanced by waypoints, for
// ledger_position_at(). Returns false when a captured edge must be taken first: *sample is right
// all the same, and the account stays.
bool axes_sample(uint8_t i, struct engine_sample *sample);

// Advance the account of an axis at rest exactly, even if a captured edge waits: before time begins
// again or the axis's lines are discarded.
void axes_advance_rested(uint8_t i);

// Bring an axis to rest and discard all its lines, from every state and as often as wanted. When
// the timer makes idle periods the axis is at rest at once; else it is STOPPING until a later call,
// and each round calls this again. When no axis is armed any more, the start token is dropped.
void axes_stop_at(uint8_t i);

// axes_stop_at(); with a single axis the compiler sees that i is 0.
static inline void axes_stop(uint8_t i)
{
    axes_stop_at(CONFIG_INDEX(i));
}

// The first axis that is armed, starting or running; NO_AXIS if none is.
uint8_t axes_first_moving(void);
// True when an axis is armed, with or without a known line zero.
bool axes_any_armed(void);
#if SEVERAL_AXES
// True when an axis is RUNNING: its line has been given to the step interrupt.
bool axes_any_running(void);
#endif
// True when an axis moves, or has more of a line queued than its start mark and its parameter.
// Settings must not change then, because segments were checked against them; those first entries
// were not.
bool axes_any_queued(void);
