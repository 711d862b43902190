// SPDX-License-Identifier: MIT
// One timer per axis that turns ring entries into STEP edges. The edges are made by the compare
// hardware; the interrupt behind this contract only loads the next period. Called from the main
// loop, interrupts on, unless said otherwise.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "motion/step_engine.h" // struct engine_sample, enum step_engine_state
#include "motion/step_ring.h"   // struct step_ring, struct pulse_train

// From the start of a period to its STEP edge, ticks.
#define STEP_TIMER_EDGE_TICKS (CONFIG_PULSE_LOW_TICKS + 1u)

// Reset every ring and start all timers in phase, idle, STEP low. Also after a fault that lost the
// time base (underrun).
void step_timer_start(void);

struct step_ring *step_timer_ring(uint8_t axis);
struct pulse_train *step_timer_trains(uint8_t axis); // STEP_TRAINS of them

// What the interrupt has consumed, as of one instant.
struct engine_sample step_timer_sample(uint8_t axis);
uint8_t step_timer_tail(uint8_t axis); // of that, the slot alone
enum step_engine_state step_timer_state(uint8_t axis);

// Changes from interrupt to interrupt, or nearly always: every 4.1 ms at the latest there is one.
uint8_t step_timer_heartbeat(uint8_t axis);

// Let the interrupt see the command that stands in this slot of the ring, and what follows it, unless
// an idle period was loaded since idle_count: then false, and nothing done.
bool step_timer_publish(uint8_t axis, uint8_t slot, uint16_t idle_count);

// The one way to rest, from every state and however often: of axis `which` nothing more of what
// stands in the ring is taken, at most the period that the timer holds already makes a STEP edge,
// and from then on every period is loaded as an idle one. Also in interrupts that let the step
// interrupts in.
void step_timer_halt(uint8_t which);

// A new beginning of an engine at rest; *slot is where the writer continues. False, and nothing
// done, while it is going: what the timer holds is not idle yet.
bool step_timer_settle(uint8_t axis, uint8_t *slot);

// The witness: the timer has made STEP edges since the last call. Told by the hardware alone,
// whatever the software believes.
bool step_timer_pulsed(uint8_t axis);

// Halt, and let the period that the timer holds make no STEP edge either. The account of steps is
// wrong from here on: step_timer_start() must follow.
void step_timer_silence(uint8_t axis);

// True when step_timer_take_underrun() will be for some axis.
bool step_timer_underrun(void);

// True once after an interrupt that came too late; the STEP output is off since.
bool step_timer_take_underrun(uint8_t axis);

// Driver enable outputs.
void step_timer_enable(uint8_t axis, bool on);
