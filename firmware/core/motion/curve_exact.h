// SPDX-License-Identifier: MIT
// A curve in exact numbers of 64 bits: how it starts, and the steps for which nothing but Newton's
// method will do. For the curve_*.c only.
#pragma once

#include "motion/curve.h"

// Take an exact residual and slope as the state.
void curve_exact_set(struct curve *curve, int64_t residual, int64_t slope);

// The next step's interval from any guess, and the state behind it. Best is a guess on the side
// from which Newton's method does not cross: too long while speeding up, too short else.
uint32_t curve_exact_next(struct curve *curve, uint32_t guess_ticks);
