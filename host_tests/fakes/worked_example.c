// SPDX-License-Identifier: MIT
#include "fakes/worked_example.h"

#define CONSTANT_PX 2u

const int16_t worked_ramp[WORKED_RAMP_PX] = {
    4,
    12,
    20,
    28,
    35,
    41,
    86,
    150,
    214,
    320,
    448,
    576,
    704,
    832,
    948,
};

// Expected positions of the worked example without backlash; with a backlash of 1000 steps they are
// the same up to pixel 15.
static const int16_t whole_positions[WORKED_ANCHORS_PX] = {
    4,
    16,
    36,
    64,
    99,
    140,
    226,
    376,
    590,
    910,
    1358,
    1934,
    2638,
    3470,
    4418,
    5418,
    6418,
};

// Expected positions of the worked example with a backlash of 250 steps.
static const int16_t quarter_positions[WORKED_ANCHORS_PX] = {
    0,
    6,
    20,
    42,
    72,
    108,
    153,
    259,
    421,
    658,
    1010,
    1490,
    2098,
    2834,
    3697,
    4668,
    5668,
};

static uint8_t lead(uint16_t backlash_steps)
{
    return backlash_steps != 0 ? 1 : 0;
}

uint16_t worked_pixels(uint16_t backlash_steps)
{
    return (uint16_t)(2u * WORKED_RAMP_PX + CONSTANT_PX + 2u * lead(backlash_steps));
}

// The segments between the marks. With backlash there is a zero pixel before and after them.
static bool worked_segment(uint16_t backlash_steps, uint8_t index, struct segment *entry)
{
    uint8_t zeros = lead(backlash_steps);

    *entry = (struct segment){.count = 0, .repeat = 1};
    if (zeros != 0 && index == 0) {
        return true;
    }
    index = (uint8_t)(index - zeros);
    if (index < WORKED_RAMP_PX) {
        entry->count = worked_ramp[index];
    } else if (index == WORKED_RAMP_PX) {
        *entry = (struct segment){.count = WORKED_SPEED, .repeat = CONSTANT_PX};
    } else if (index <= 2u * WORKED_RAMP_PX) {
        entry->count = worked_ramp[2u * WORKED_RAMP_PX - index];
    } else {
        return zeros != 0 && index == 2u * WORKED_RAMP_PX + 1u;
    }
    return true;
}

bool worked_entry(uint16_t backlash_steps, uint8_t index, struct segment *entry)
{
    uint8_t runs = (uint8_t)(2u * WORKED_RAMP_PX + 1u + 2u * lead(backlash_steps));

    if (index == 0) {
        *entry =
            (struct segment){LINE_MARK_START | LINE_START_SMOOTH | LINE_START_WAIT, 0};
        return true;
    }
    if (index == 1) {
        *entry = (struct segment){(int16_t)backlash_steps,
                                  backlash_steps != 0 ? WORKED_SPEED : 0};
        return true;
    }
    if (index == runs + 2u) {
        *entry = (struct segment){LINE_MARK_END, 0};
        return true;
    }
    return index < runs + 2u &&
           worked_segment(backlash_steps, (uint8_t)(index - 2u), entry);
}

int32_t worked_position(uint16_t backlash_steps, uint16_t pixel)
{
    const int16_t *anchors = backlash_steps == 250 ? quarter_positions : whole_positions;
    uint16_t first_fall = (uint16_t)(worked_pixels(backlash_steps) -
                                     lead(backlash_steps) - WORKED_RAMP_PX + 1u);
    int32_t position = 0;

    if (pixel <= WORKED_ANCHORS_PX) {
        return anchors[pixel - 1u];
    }
    position = anchors[WORKED_ANCHORS_PX - 1u];
    for (uint16_t k = WORKED_ANCHORS_PX + 1u; k <= pixel; k++) {
        if (k < first_fall) {
            position += (int32_t)WORKED_SPEED;
        } else if (k < first_fall + WORKED_RAMP_PX) {
            position += worked_ramp[WORKED_RAMP_PX - 1u - (k - first_fall)];
        }
    }
    return position;
}
