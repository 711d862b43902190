// SPDX-License-Identifier: MIT
#include "fakes/trace.h"

static uint16_t turned;
static uint16_t sum;

void trace_begin(void)
{
    turned = 0;
    sum = 0;
}

void trace(uint16_t word)
{
    turned = (uint16_t)((uint16_t)(turned << 1 | turned >> 15) + word);
    sum = (uint16_t)(sum + turned);
}

void trace_long(uint32_t word)
{
    trace((uint16_t)word);
    trace((uint16_t)(word >> 16));
}

uint32_t trace_number(void)
{
    return (uint32_t)turned << 16 | sum;
}
