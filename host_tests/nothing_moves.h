// SPDX-License-Identifier: MIT
// The check that several machine suites share: for 200 rounds no axis makes a step, and every
// position is that of the edges made.
#pragma once

#include <stdint.h>

#include "fakes/board.h"
#include "fakes/board_bench.h"
#include "unity.h"

static inline void check_nothing_moves(void)
{
    int32_t steps[CONFIG_AXES];

    bench_rounds(3);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        steps[i] = fake_axes[i].steps;
    }
    bench_rounds(200);
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        TEST_ASSERT_EQUAL_INT32(steps[i], fake_axes[i].steps);
        TEST_ASSERT_EQUAL_INT32(steps[i], ledger_position(&axes_get(i)->ledger));
    }
}
