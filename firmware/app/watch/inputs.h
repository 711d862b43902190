// SPDX-License-Identifier: MIT
// Home and limit switches, filtered: a change counts when it has lasted settings.input_filter_us.
// Main loop only.
//
//     pin      ____/~\_/~~~~~~~~~~~~~~
//                     |-- filter --|
//     filtered ____________________/~~
//
// Each switch has a filter of its own: one that chatters must not hide another. The exact instant
// of a home switch's edge comes from the capture hardware (app/motion/seek.h), never from here.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Every switch is open until the filter has seen otherwise.
void inputs_start(void);

// Sample one axis's switches and filter them. Latches fault limit_plus or limit_minus when a
// running axis has moved on towards a limit switch that is tripped; an axis may move away from it.
// A home switch is one of the limits where setting home_is_limit says so: its fault waits while
// home_is_sought, that is, while a seek of the axis has met the switch. Called for one axis after
// the other, round by round.
void inputs_poll(uint8_t axis, bool home_is_sought);

// Filtered state of the axis's home switch: true when closed, whatever level that is at the pin.
bool inputs_home_closed(uint8_t axis);

// True when more than settings.input_filter_us has passed since since_units, the low 16 bits of
// clock_now_units().
bool inputs_lasted(uint16_t since_units);

// True when the settings say that a home switch is closed while its pin is high, instead of low.
bool inputs_home_inverted(void);

// True when the axis's home switch has not changed for the filter's time, so that its filtered
// state is that of its pin.
bool inputs_settled(uint8_t axis);

// Input register `inputs`: four bits for each axis, axis 0 lowest; set for closed or tripped.
//
//     bit    3    2            1             0
//            -    limit plus   limit minus   home          SWITCH_* of hal/switches.h
uint16_t inputs_all(void);
