// SPDX-License-Identifier: MIT
// Pixels of many evenly spaced steps, each of them a pulse train: the common case of several axes
// at constant speed. Such a pixel goes from the line's segment to the stream at once. The entries
// are those that piece, walk and feed would write, at half the cost. Main loop only.
//
//     steps      1 2 ... stagger | stagger + 1                ...                     n
//     entries    one each        | one for every 127 of them
//
// All axes of a board cross a pixel edge together. Each axis makes another number of single steps
// (`stagger`) in front of its train, so that no two step interrupts begin a train at once.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "stream/even.h"   // struct even
#include "stream/stream.h" // struct stream

struct line;

// Fewer evenly spaced steps than this are not worth a pulse train, unless their interval is below
// TRAIN_ENTRY_MIN_TICKS.
#define TRAIN_MIN_STEPS 16u
// Below this interval (ticks) the step interrupt cannot switch from a single period to a pulse
// train in time, only from one train to another.
#define TRAIN_ENTRY_MIN_TICKS 160u
// The next pulse train waits until one of the two trains is free if the newer one is at least this
// long, ticks. After a shorter train there is no time to wait, and single periods follow, which
// cost the main loop four times as much.
#define TRAIN_WAIT_TICKS ((uint32_t)0x2000)

// The most steps in front of a train.
#define TRAIN_STAGGER_MAX 8u

// The longest train of a whole pixel, entries and steps. A pixel of more steps goes by way of
// pieces.
#define TRAIN_PIXEL_MAX_ENTRIES 16u
#define TRAIN_PIXEL_MAX_STEPS   (TRAIN_PIXEL_MAX_ENTRIES * STEP_TRAIN_ENTRY_MAX)

// What became of the next pixel.
enum train_pixel {
    // The next pixel does not have many even steps.
    TRAIN_PIXEL_OTHER,
    // Written.
    TRAIN_PIXEL_DONE,
    // The pixel must wait until one of the two trains is free.
    TRAIN_PIXEL_WAITS,
    // No train can make it: its first step is written. train_pixel_singles() is to write the
    // others, and a waypoint must follow.
    TRAIN_PIXEL_SINGLES,
};

// Write the line's next pixel if its steps, more than EVEN_PIXEL_MAX_STEPS, are even and go in the
// direction of the steps before it. even: the walk along the last such pixel; anything may stand
// there. stagger: steps in front of the train, 0..TRAIN_STAGGER_MAX. Only after even_pixels_write()
// found another pixel than its own, where that may be asked, and when the pixel has its length
// (line_is_early() is false). TRAIN_PIXEL_OTHER and TRAIN_PIXEL_WAITS: nothing was written.
enum train_pixel train_pixel_write(struct line *line,
                                   struct even *even,
                                   struct stream *stream,
                                   bool negative,
                                   uint8_t stagger);

// Append the next `count` of evenly spaced steps, each of them an entry, and pass them in *even.
// count: up to stream_space(). The intervals must fit single periods, and no waypoint may wait.
// Returns the ticks of these steps together.
uint32_t train_pixel_singles(struct even *even, struct stream *stream, uint8_t count);
