// SPDX-License-Identifier: MIT
//
// The contact of one switch: it follows the switch after a delay, and bounces. Times are in cycles
// (ticks).
//
//   switch    ______/-----------------------------------
//                   |<-- delay -->|<- bounce_ticks ->|
//   contact   ____________________/-\__/--\_/-----------       bounce = 4
//                                 ^ first edge    ^ last edge
//
// A change that is due while the contact still bounces from the change before ends that bouncing.
//
// A contact does nothing by itself: its owner asks when it is next due, and lets it move then.
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "noise.h"

#define CONTACT_NEVER       UINT64_MAX
#define CONTACT_BOUNCE_MOST 64
// Changes of the switch that the contact has not followed yet; a power of two.
#define CONTACT_CHANGES 64

struct contact_settings {
    uint32_t delay_ticks; // from a change of the switch to the contact's first edge
    // Edges after the first one of each change. Even, so that the contact ends in the right state.
    uint32_t bounce;
    uint32_t bounce_ticks; // the time in which they fall, each in a cycle of its own
};

struct contact {
    bool closed;        // now
    bool switch_closed; // the state of its switch, which the contact will follow
    struct noise random;

    // A ring: changes of the switch, and when the contact's first edge of each is due.
    struct {
        uint64_t due;
        bool closed;
    } change[CONTACT_CHANGES];
    unsigned change_first, change_last;

    // The cycles of the bouncing of the change that was due last, in their order.
    uint64_t bounce_at[CONTACT_BOUNCE_MOST];
    unsigned bounces, bounce_next;
};

// One edge of a contact.
struct contact_edge {
    uint64_t cycle;
    bool bounce; // not the first edge of its change
};

// Puts the contact into this state, at rest.
void contact_settle(struct contact *contact, bool closed);

// Seeds the random cycles of the bouncing: the same seed and place give the same cycles.
void contact_seed(struct contact *contact, uint64_t seed, unsigned place);

// The switch has this state from this cycle on. False if more than CONTACT_CHANGES of its changes
// still wait for their delay.
bool contact_follow(struct contact *contact,
                    const struct contact_settings *settings,
                    bool closed,
                    uint64_t cycle);

// The cycle of the contact's next edge, CONTACT_NEVER if it is at rest.
uint64_t contact_due(const struct contact *contact);

// Makes the edge that is due next. False if the contact does not change (bouncing had already put
// it into the new state).
bool contact_move(struct contact *contact,
                  const struct contact_settings *settings,
                  struct contact_edge *edge);
