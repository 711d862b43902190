// SPDX-License-Identifier: MIT
// Setting `divider` behind the start mark of a line: what core needs from who links it. The
// firmware's is in app/registers/data.c.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// Make a pixel so many clock edges, before the first segment of a line is checked. Nothing happens
// when a pixel has so many already; a change is a write of the setting. behind: segments of another
// line were checked before this one since the axis was at rest. Returns false, and nothing has
// changed, when the number is not possible, or not now.
bool line_divider_take(uint16_t edges, bool behind);
