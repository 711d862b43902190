// SPDX-License-Identifier: MIT
//
// What the run has cost, as one line of JSON.
#pragma once

#include <stdio.h>

#include "bench.h"

// {"cycle":..,"wall_s":..,"realtime_factor":..,"boards":[{"name":..,"handlers":[{"vector":..,
//  "name":..,"count":..,"cycles_min":..,"cycles_mean":..,"cycles_max":..,"latency_max":..}],
//  "interrupt_cycles":..,"sections":[..],"sleep_cycles":..,"stack_free_bytes":..,
//  "stack_used_bytes":..,"axes":[{"steps_rising":..,"steps_signed":..}],
//  "interrupts_off_max_cycles":..}]}, without a line end.
void stats_write(FILE *out, struct bench *bench);
