// SPDX-License-Identifier: MIT
//
// The statistics of a run, as one line of JSON: times, handlers, sections, stack, steps.
#pragma once

#include <stdio.h>

#include "bench.h"

// Writes the statistics without a line end:
//
// {"cycle":..,"wall_s":..,"cpu_s":..,"realtime_factor":..,"boards":[
//   {"name":..,
//    "handlers":[{"vector":..,"name":..,"count":..,"cycles_min":..,"cycles_sum":..,
//                 "cycles_mean":..,"cycles_max":..,"latency_max":..}],
//    "interrupt_cycles":..,"sections":[..],"section_entries":[..],
//    "section_longest":[..],"sleep_cycles":..,"stack_free_bytes":..,"stack_used_bytes":..,
//    "axes":[{"steps_rising":..,"steps_signed":..}],
//    "interrupts_off_max_cycles":..,"interrupts_off_main_max_cycles":..}]}
//
// Times without a unit in the name are cycles. Handlers that never ran are left out.
void stats_write(FILE *out, struct bench *bench);
