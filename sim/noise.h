// SPDX-License-Identifier: MIT
//
// Random numbers that are the same in every run with the same seed: jitter, bouncing, and the
// content of a memory that nobody has written. Each user has a sequence of its own, so that one
// more number here changes nothing there.
#pragma once

#include <stddef.h>
#include <stdint.h>

struct noise {
    uint64_t state; // never 0
};

// Starts a sequence. The same seed and place give the same sequence; different places of the same
// seed give different ones.
static inline void noise_seed(struct noise *noise, uint64_t seed, unsigned place)
{
    noise->state = (seed + place) * 0x9E3779B97F4A7C15U + place + 1;
    if (noise->state == 0) {
        noise->state = 1;
    }
}

// The next 64 random bits (xorshift64*).
static inline uint64_t noise_next(struct noise *noise)
{
    noise->state ^= noise->state >> 12;
    noise->state ^= noise->state << 25;
    noise->state ^= noise->state >> 27;
    return noise->state * 0x2545F4914F6CDD1DU;
}

// The next random byte.
static inline uint8_t noise_byte(struct noise *noise)
{
    return (uint8_t)(noise_next(noise) >> 56);
}

// Fills a memory with random bytes.
static inline void noise_fill(struct noise *noise, uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        bytes[i] = noise_byte(noise);
    }
}
