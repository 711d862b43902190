// SPDX-License-Identifier: MIT
// What the account of an axis knows. The functions of ledger.h and ledger_waypoints.h write it, and
// their assembly finds the members by offsets that the compiler generates (avr/layout.c). axis.c
// also writes `pixel` and lines_done, at the start and the end of a line. Main loop only.
//
//     single periods | lengths[2] | lengths[1] | lengths[0] | a train: train_steps of it, of which
//                                                           | `left` are not loaded yet
//                                              loaded_ticks ^
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "account/play.h"    // struct play
#include "account/records.h" // struct records

// Value of ledger.train outside a pulse train.
#define LEDGER_NO_TRAIN 0xFFu

struct ledger {
    // Periods at this place of the stream pulse.
    bool pulse;
    // Steps at this place go in negative direction.
    bool negative;
    // Periods that are accounted for but not loaded yet, 0..127; all of them belong to the last
    // entry of a train. 0 outside a train.
    uint8_t left;
    // The train at this place, 0 or 1; LEDGER_NO_TRAIN if there is none.
    uint8_t train;
    // Steps of this train that are accounted for, the steps of `left` included; 0 outside a train.
    uint16_t train_steps;
    // Idle periods that are accounted for; wraps as the engine's idle_count does.
    uint16_t idle_seen;
    // Lengths of the last three single periods before the train, ticks, the newest first.
    uint16_t lengths[3];
    // Number of newer single periods whose lengths are not in lengths[] yet, because they still
    // stand in the ring (0..3).
    uint8_t fresh;
    // Of the periods in lengths[], bit 0 the newest: the period began with a STEP edge.
    uint8_t pulsed;
    // End of the newest period that is accounted for outside a train, ticks since the timers
    // started; wraps. Inside a train: where the train began.
    uint32_t loaded_ticks;
    // Signed steps since reset, or since ledger_zero(), the steps of `left` included.
    int32_t position_steps;
    // Position where the line began, steps: the records' positions count from here.
    int32_t line_origin;
    // Pixel edges passed in the line; the newest record is of the pixel with this number, from 1.
    uint32_t pixel;
    // Lines whose end was passed since reset; wraps.
    uint16_t lines_done;
    // How much of the play is taken up at this place.
    struct play play;
    // Last, so that the members before it lie within reach of a pointer's displacement (63 bytes).
    struct records records;
};

// Count `steps` steps, 0..32767, in the direction that steps have at this place.
static inline void ledger_move_position(struct ledger *ledger, uint16_t steps)
{
    ledger->position_steps += ledger->negative ? -(int16_t)steps : (int16_t)steps;
}
