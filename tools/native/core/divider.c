// SPDX-License-Identifier: MIT
// The divider of a line on the host: its pixels are those of the limits that come with it.
#include "line/line_divider.h"
#include "wire/register_map.h" // REG_HOLDING_divider

#define INPUT(address, name, type, unit, meaning)
#define INPUT_AXIS(offset, name, type, unit, meaning)
#define COMMAND(address, name, type, unit, min, max, initial, meaning)

struct range {
    uint32_t min;
    uint32_t max;
};

static const struct range ranges[] = {
#define HOLDING(address, name, type, unit, min, max, initial, meaning)                   \
    [address] = {(min), (max)},
#include "wire/registers.def"
#undef HOLDING
};

bool line_divider_take(uint16_t edges, bool behind)
{
    (void)behind;
    return edges >= ranges[REG_HOLDING_divider].min &&
           edges <= ranges[REG_HOLDING_divider].max;
}
