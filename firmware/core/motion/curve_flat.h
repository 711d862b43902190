// SPDX-License-Identifier: MIT
// Where the interval hardly changes from step to step, everything about the next step follows from
// this one by additions. For curve.c.
#pragma once

#include <stdint.h>

#include "motion/curve.h"

// Up to `count` steps of a curve that is flat and narrow; returns how many (0 when the last
// interval is not known).
uint8_t curve_flat_batch(struct curve *curve, uint16_t *intervals, uint8_t count);
