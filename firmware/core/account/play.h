// SPDX-License-Identifier: MIT
// How much of an axis's play is taken up. The load stands still while the motor crosses the play:
//
//     motor    |---- plus ------------>|            all of the play is taken up: run = steps
//                     |<------ minus --| turns      run = 0, then 1, 2, ...
//                     |-- plus -->                  turns again: run = steps - run
//
// The run is the number of steps that are taken up in the direction of the last step: 0 up to the
// steps of the play. The run is kept as a place, where it would be 0: steps then need no account
// here, and a motor that is stopped anywhere has the right run. A place is the low 16 bits of the
// position, with its sign changed while the direction is negative, so that every step adds 1 to it.
//
// The ledger calls play_settle() and play_turn(); axis.c tells the play of a line and asks how much
// of it the line must take up. Images without FEATURE_BACKLASH do neither. Main loop only.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// A bit of member `steps`: the motor has not crossed the play in one go since reset, or since
// another number of steps was told. Then the run is the least that can be taken up.
#define PLAY_UNKNOWN 0x8000u
// The bits of member `steps` that are the number of steps.
#define PLAY_STEPS 0x7FFFu
// The number of steps before anybody told one; more than a line may tell.
#define PLAY_UNTOLD PLAY_STEPS

struct play {
    // The place where the run is 0, modulo 2^16.
    uint16_t from;
    // Steps of the play, 1..PLAY_UNTOLD, and PLAY_UNKNOWN.
    uint16_t steps;
};

// Nobody told the play, and the motor, at position 0, has made no step.
static inline void play_reset(struct play *play)
{
    play->from = 0;
    play->steps = PLAY_UNTOLD | PLAY_UNKNOWN;
}

// True when the run is exact: the motor has crossed all of the play since its steps were told.
static inline bool play_known(const struct play *play)
{
    return (play->steps & PLAY_UNKNOWN) == 0;
}

// Take note of the steps made up to `place`, and return the run, which ends at the steps of the
// play. A run that comes to the end makes the play known. To be called before every change of
// direction, and at least once in 32767 steps.
static inline uint16_t play_settle(struct play *play, uint16_t place)
{
    uint16_t steps = play->steps & PLAY_STEPS;
    uint16_t run = (uint16_t)(place - play->from);

    if (run >= steps) {
        run = steps;
        play->steps = steps;
        play->from = (uint16_t)(place - steps);
    }
    return run;
}

// The play has `steps` steps, 1 to PLAY_UNTOLD - 1. If another number was told before, nothing is
// known of the new play, and its run begins here. If none was told, the run so far stays. run: as
// play_settle() has just returned it.
static inline void play_tell(struct play *play, uint16_t run, uint16_t steps)
{
    uint16_t before = play->steps & PLAY_STEPS;

    if (steps == before) {
        return;
    }
    if (before != PLAY_UNTOLD) {
        play->from = (uint16_t)(play->from + run);
    }
    play->steps = steps | PLAY_UNKNOWN;
}

// The motor turns round at the place for which play_settle() has just returned this run. The run in
// the new direction is what is left of the play, or 0 while the play is not known.
static inline void play_turn(struct play *play, uint16_t run)
{
    if (play_known(play)) {
        run = play->steps;
    }
    // The place's sign changes with the direction.
    play->from = (uint16_t)(0u - play->from - run);
}
