// SPDX-License-Identifier: MIT
// What must hold, judged from the STEP edges, the permit output and what the host is told.
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct part_access;

// Each name is what a run is reported under.
#define JUDGE_RUNAWAY  "runaway: an edge after the last one allowed"
#define JUDGE_EARLY    "an edge before the release"
#define JUDGE_PERMIT   "permit is high"
#define JUDGE_POSITION "the position is not the edges made"
#define JUDGE_STUCK    "the axis cannot be used again"
#define JUDGE_REFUSED  "a refused command changed something"
#define JUDGE_PROMISE  "a promise of the firmware is broken"
#define JUDGE_ESTOP    "the emergency stop went unheard"
#define JUDGE_SCENARIO "the scenario does not come"
#define JUDGE_WIDE     "a shared word is accessed with interrupts on"
#define JUDGE_DIVIDES  "the program divides by zero"
#define JUDGE_ENDLESS  "the program does not come to an end"
// Where there are several axes.
#define JUDGE_TICK       "an edge is not at its tick"
#define JUDGE_DIRECTION  "an edge in the wrong direction"
#define JUDGE_LATE       "a step interrupt is late"
#define JUDGE_TOGETHER   "axes do not begin on one edge of the clock"
#define JUDGE_FAULT      "a fault that nothing gave cause for"
#define JUDGE_UNFINISHED "a line that nothing stopped is not made to its end"
#define JUDGE_HANGS      "an axis does not come to rest"

// The run is over: `rule` does not hold.
_Noreturn void judge_broken(const char *rule);
// An interrupt touched what was not known to be shared.
void judge_unshared(const volatile void *address);

void judge_edge(uint8_t axis, uint32_t ticks, bool negative);
void judge_look(void); // at every point
void judge_access(const struct part_access *access);
void judge_between(void); // the main loop is between two pieces of its program
void judge_rest(void);    // bring the axis to rest; then it must be usable
