// SPDX-License-Identifier: MIT
// How a rule came to be broken.
#pragma once

#include <stdint.h>
#include <stdio.h>

#include "explore/states.h"

void report_begin(FILE *report, uint16_t scenario);
void report_way(FILE *report, const struct steps *steps, uint32_t last);
void report_last(FILE *report, const struct step *last); // NULL: it was at rest
