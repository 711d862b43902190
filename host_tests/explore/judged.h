// SPDX-License-Identifier: MIT
// What the judge knows of the one axis.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define JUDGE_ANY_NUMBER 255u

// Part of the state that the search saves.
struct judged {
    int32_t position; // edges made, signed
    uint8_t edges_allowed;
    bool permit_given;
};

extern struct judged judged;
