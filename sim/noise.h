// SPDX-License-Identifier: MIT
//
// Noise that is the same in every run with the same seed: what a memory holds that nobody wrote.
#pragma once

#include <stddef.h>
#include <stdint.h>

struct noise {
    uint64_t state;
};

// The same seed and place give the same row; places differ from each other.
static inline void noise_seed(struct noise *noise, uint64_t seed, unsigned place)
{
    noise->state = (seed + place) * 0x9E3779B97F4A7C15U + place + 1;
    if (noise->state == 0) {
        noise->state = 1;
    }
}

// xorshift64*
static inline uint64_t noise_next(struct noise *noise)
{
    noise->state ^= noise->state >> 12;
    noise->state ^= noise->state << 25;
    noise->state ^= noise->state >> 27;
    return noise->state * 0x2545F4914F6CDD1DU;
}

static inline uint8_t noise_byte(struct noise *noise)
{
    return (uint8_t)(noise_next(noise) >> 56);
}

static inline void noise_fill(struct noise *noise, uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        bytes[i] = noise_byte(noise);
    }
}
