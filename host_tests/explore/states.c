// SPDX-License-Identifier: MIT
#include "explore/states.h"

#include <stdlib.h>
#include <string.h>

#include "explore/program.h" // allocate

// Slots of a new table, a power of two.
#define FIRST_SLOTS 4096u

static uint32_t *slot_of(const struct layer *layer, const uint64_t hash[2])
{
    uint32_t slot = (uint32_t)hash[0] & (layer->slot_count - 1u);

    while (layer->slots[slot] != 0) {
        const struct state *state = &layer->states[layer->slots[slot] - 1u];
        if (state->hash[0] == hash[0] && state->hash[1] == hash[1]) {
            break;
        }
        slot = (slot + 1u) & (layer->slot_count - 1u);
    }
    return &layer->slots[slot];
}

static void clear_slots(struct layer *layer)
{
    if (layer->slots != NULL) {
        memset(layer->slots, 0, layer->slot_count * sizeof *layer->slots);
    }
}

static void add_slots(struct layer *layer)
{
    layer->slot_count = layer->slot_count == 0 ? FIRST_SLOTS : 4u * layer->slot_count;
    layer->slots = allocate(layer->slots, layer->slot_count * sizeof *layer->slots);
    clear_slots(layer);
    for (uint32_t i = 0; i < layer->count; i++) {
        *slot_of(layer, layer->states[i].hash) = i + 1u;
    }
}

struct state *layer_find(struct layer *layer, const uint64_t hash[2])
{
    if (2u * layer->count >= layer->slot_count) {
        add_slots(layer);
    }
    uint32_t *slot = slot_of(layer, hash);
    if (*slot != 0) {
        return &layer->states[*slot - 1u];
    }
    if (layer->count == layer->room) {
        layer->room = 2u * layer->room + 256u;
        layer->states = allocate(layer->states, layer->room * sizeof *layer->states);
    }
    struct state *state = &layer->states[layer->count];
    layer->count++;
    *slot = layer->count;
    *state = (struct state){.hash = {hash[0], hash[1]}};
    return state;
}

void layer_empty(struct layer *layer)
{
    for (uint32_t i = 0; i < layer->count; i++) {
        free(layer->states[i].memory);
    }
    if (layer->count != 0) {
        clear_slots(layer);
    }
    layer->count = 0;
}

void layer_swap(struct layer *now, struct layer *next)
{
    struct layer done = *now;

    *now = *next;
    *next = done;
    layer_empty(next);
}

uint32_t steps_add(struct steps *steps, const struct step *step)
{
    if (steps->count == steps->room) {
        steps->room = 2u * steps->room + 1024u;
        steps->steps = allocate(steps->steps, steps->room * sizeof *steps->steps);
    }
    steps->steps[steps->count] = *step;
    return steps->count++;
}
