// SPDX-License-Identifier: MIT
// One 16-bit timer per axis makes STEP edges of ring entries. The compare hardware makes the edges;
// the interrupt behind this contract only loads the period after the current one.
//
//     period n                                   period n + 1
//     |--low--|^^^^^^^^^^^^^ STEP high ^^^^^^^^^^|--low--|^^^^^^
//     |       +- STEP edge: STEP_TIMER_EDGE_TICKS from the start of the period
//     +- the step interrupt loads period n + 1: it has all of period n to do so
//
// Called from the main loop with interrupts on, unless a function says otherwise.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "config.h"           // CONFIG_INDEX
#include "ring/step_engine.h" // struct engine_sample, enum step_engine_state
#include "ring/step_ring.h"   // struct step_ring, struct pulse_train

// From the start of a period to its STEP edge, ticks.
#define STEP_TIMER_EDGE_TICKS (CONFIG_PULSE_LOW_TICKS + 1u)

// Reset every ring and start all timers in phase, idle, with STEP low. Also called after a fault
// that lost the time base (underrun).
void step_timer_start(void);

// The ring that the axis's step interrupt reads.
struct step_ring *step_timer_ring(uint8_t axis);
// The STEP_TRAINS pulse trains of that interrupt.
struct pulse_train *step_timer_trains(uint8_t axis);

// *sample: what the interrupt has consumed, as of one instant.
void step_timer_sample(uint8_t axis, struct engine_sample *sample);
// One instant of an axis and of the coarse clock.
struct step_timer_look {
    struct engine_sample sample;
    uint16_t counter; // ticks since the running period began
    uint32_t units;   // clock_now_units()
};
// Look at an axis; several axes only. Returns false when it is parked, so that no interrupt counts,
// and when interrupts came too densely for a look.
bool step_timer_look(uint8_t axis, struct step_timer_look *look);
// Of such a sample the slot alone.
uint8_t step_timer_tail(uint8_t axis);
// State of the axis's engine.
enum step_engine_state step_timer_state(uint8_t axis);

// A number that nearly every step interrupt changes; a step interrupt comes every 4.1 ms at the
// latest, unless the axis is parked.
uint8_t step_timer_heartbeat(uint8_t axis);

// Publish the command in this slot of the ring, and the entries behind it, unless an idle period
// was loaded since idle_count: then the function returns false and changes nothing.
bool step_timer_publish(uint8_t axis, uint8_t slot, uint16_t idle_count);

// Park an axis at rest, so that its idle periods cost no interrupt; every other function here works
// as before. idle_count: of a sample by which the running and the newest loaded period are idle
// ones. Returns false and changes nothing if a period began since, or if the axis is not idle: try
// again later. Captured edges that wait must have been taken before.
bool step_timer_park(uint8_t axis, uint16_t idle_count);

// Let the step interrupt serve a parked axis again; the count of idle periods goes on. Returns
// false, and the axis stays parked, if it was halted meanwhile: step_timer_settle() must come
// first. Does nothing to an axis that is not parked.
bool step_timer_unpark(uint8_t axis);

// Bring an axis to rest, from every state and as often as wanted: nothing more of its ring is
// taken, at most the period that the timer holds already makes a STEP edge, and every later period
// is an idle one. May also be called in interrupts that let the step interrupts in.
void step_timer_halt_at(uint8_t which);

static inline void step_timer_halt(uint8_t which)
{
    step_timer_halt_at(CONFIG_INDEX(which));
}

// Start anew an engine at rest; *slot is where the writer continues. Returns false and changes
// nothing while the engine is going, because the period that the timer holds may pulse.
bool step_timer_settle(uint8_t axis, uint8_t *slot);

// The timer has made STEP edges since the last call. Only the hardware's flag decides, whatever the
// software's state is.
bool step_timer_pulsed(uint8_t axis);

// Halt the axis, and suppress even the STEP edge of the period that the timer holds. The account of
// steps is wrong afterwards: step_timer_start() must follow.
void step_timer_silence(uint8_t axis);

// True when step_timer_take_underrun() will be true for some axis.
bool step_timer_underrun(void);

// True once after an interrupt that came too late; the axis's STEP output is off since then.
bool step_timer_take_underrun(uint8_t axis);

// Switch the axis's motor driver on or off.
void step_timer_enable(uint8_t axis, bool on);
