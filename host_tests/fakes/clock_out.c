// SPDX-License-Identifier: MIT
// A fake of hal/clock_out.h: it keeps what it was told.
#include "hal/clock_out.h"

#include "fakes/board.h"

uint16_t fake_clock_out_hz;

void clock_out_set(uint16_t hz)
{
    fake_clock_out_hz = hz;
}
