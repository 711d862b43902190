// SPDX-License-Identifier: MIT
// The real firmware of the Uno above the explored part: scenarios, commands, and what it says.
#pragma once

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct part_access;

void board_open(void); // once, before anything is saved
void board_power_on(void);

// A situation to start from.
uint16_t board_scenarios(void);
const char *board_scenario(uint16_t scenario);
bool board_prepare(uint16_t scenario); // from power-on; false: the situation did not come

// What the host, or a hand at the emergency stop, may do.
uint8_t board_actions(void);
const char *board_action(uint8_t action);
void board_act(uint8_t action);

// The main loop, once. A millisecond later.
void board_round(void);

// A period ends while the main loop is between two rounds; then a round.
void board_idle(void);

bool board_held(void);     // armed, not released
bool board_moving(void);   // armed or running
bool board_finished(void); // the last line came to its end
bool board_stopped(void);  // a fault is recorded or the emergency stop latched
bool board_halted(void);   // the engine loads no periods of a line any more
bool board_promise_broken(void);
bool board_estop_recorded(void);
// A word that may be accessed with interrupts on.
bool board_excused(const struct part_access *access);
int32_t board_position(void);

// Clear, discard, run a line of two steps to its end. False when something of that is refused or
// does not come.
bool board_recovers(void);

// Engine, axis and position, for a report.
void board_describe(FILE *report);
