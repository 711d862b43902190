// SPDX-License-Identifier: MIT
//
// One switch's contact: it follows its switch so many cycles later, and bounces.
//
//   switch    ______/-----------------------------------
//                   |<-- delay -->|<- bounce_ticks ->|
//   contact   ____________________/-\__/--\_/-----------       bounce = 4
//                                 ^ first edge    ^ last edge
//
// A change that is due while the contact still bounces from the one before ends that bouncing.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "noise.h"

#define CONTACT_NEVER       UINT64_MAX
#define CONTACT_CHANGES     64 // under way at once; a power of two
#define CONTACT_BOUNCE_MOST 64

struct contact_settings {
    uint32_t delay_ticks;
    uint32_t
        bounce; // edges after the first of each change: even, to end in the right state
    uint32_t bounce_ticks; // within which they fall, each in a cycle of its own
};

struct contact {
    bool closed; // now
    bool told;   // what it has last been told to become
    struct noise random;

    struct {
        uint64_t due;
        bool closed;
    } change[CONTACT_CHANGES];
    unsigned change_first, change_last;

    uint64_t bounce_at[CONTACT_BOUNCE_MOST]; // of the change that was due last, in order
    unsigned bounces, bounce_next;
};

// What a contact did.
struct contact_edge {
    uint64_t cycle;
    bool bounce; // not the first edge of its change
};

// At rest in this state, with nothing under way.
void contact_settle(struct contact *contact, bool closed);

// Where its bouncing starts from: the same seed and place give the same cycles.
void contact_seed(struct contact *contact, uint64_t seed, unsigned place);

// Its switch is so at this cycle. False if too many changes are under way.
bool contact_follow(struct contact *contact,
                    const struct contact_settings *settings,
                    bool closed,
                    uint64_t cycle);

// When the contact next does something, CONTACT_NEVER if it is at rest.
uint64_t contact_due(const struct contact *contact);

// Does it. False if the contact is as it was before (a change that bouncing had reached).
bool contact_move(struct contact *contact,
                  const struct contact_settings *settings,
                  struct contact_edge *edge);
