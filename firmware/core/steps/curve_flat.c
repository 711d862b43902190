// SPDX-License-Identifier: MIT
#include "steps/curve_flat.h"

#include <stddef.h> // offsetof

#include "base/apart.h"     // APART
#include "base/multiply.h"  // multiply_*
#include "build_features.h" // FEATURE_NARROW_CURVES
#include "ring/step_ring.h" // struct step_ring

// How far the loop over the steps got. The loop ends early where the high byte of q - 1 changes.
struct progress {
    uint16_t
        extra_ticks; // ticks beyond q of the loop's start, for each step; may be negative
    uint8_t left;    // steps that were not made
    uint8_t
        carried; // not 0: a low byte is 0 by a carry, and its high byte is one too low
};

// Limits of speed * T, in units of 2^8. The interval changes by c = a*T/v^3 ticks from step to
// step, and rounding adds one tick. Behind a step of q or q + 1 ticks the sums therefore belong to
// a place up to c + 2 ticks from the root. Each tick adds speed * T, so that c + 2 times speed * T
// must fit half the modulus. The limits are for c = 1 and, where their names say LOOSE, for c = 4.
#define NARROW_MAX       0x002A0000
#define NARROW_LOOSE_MAX 0x00150000
#define WIDE_MAX         0x2A000000
#define WIDE_LOOSE_MAX   0x15000000
// slope_growth is below c * v^2, and the narrow loop keeps three bytes of it.
#define NARROW_SPEED_MAX       2800u
#define NARROW_LOOSE_SPEED_MAX 1400u
// Largest speed whose cube fits 40 bits.
#define CUBE_MAX 8191u
// An interval fits 16 bits as long as T is no more than this many times the speed.
#define INTERVAL_MAX 0xFB00u

// The kind of a curve whose largest speed is `speed`; slope: speed * T without its lowest 8 bits.
// loose: the interval may change by up to 4 ticks from step to step, else by up to 1.
static enum curve_flat_kind kind_of(int32_t slope, uint16_t speed, bool loose)
{
    if (slope >= (loose ? WIDE_LOOSE_MAX : WIDE_MAX)) {
        return CURVE_FLAT_NOT;
    }
    return FEATURE_NARROW_CURVES && slope < (loose ? NARROW_LOOSE_MAX : NARROW_MAX) &&
                   speed <= (loose ? NARROW_LOOSE_SPEED_MAX : NARROW_SPEED_MAX)
               ? CURVE_FLAT_NARROW
               : CURVE_FLAT_WIDE;
}

// The cube of the speed, without its lowest 8 bits: the a*T at which the interval changes by one
// tick from step to step.
static int32_t cube_of(uint16_t speed)
{
    uint16_t base = speed < CUBE_MAX ? speed : CUBE_MAX;

    return wide_times(wide_from_int32((int32_t)multiply_u32_u16(base, base)), base).high;
}

// speed * T, without its lowest 8 bits.
static int32_t slope_of(uint32_t ticks, uint16_t speed)
{
    return wide_times(wide_from_int32((int32_t)ticks), speed).high;
}

APART enum curve_flat_kind curve_flat_now(uint32_t ticks, uint16_t top_speed, bool loose)
{
    return kind_of(slope_of(ticks, top_speed), top_speed, loose);
}

// The a*T below which the interval changes by less than one tick from step to step at this speed;
// 0 if the interval does not fit.
static int32_t flat_limit(uint32_t ticks, uint16_t speed)
{
    return multiply_u32_u16(INTERVAL_MAX, speed) >= ticks ? cube_of(speed) : 0;
}

enum curve_flat_kind curve_flat_kind(uint32_t ticks,
                                     uint16_t start_speed,
                                     uint16_t end_speed,
                                     bool *stays)
{
    bool faster = end_speed > start_speed;
    uint16_t top = faster ? end_speed : start_speed;
    uint16_t low = faster ? start_speed : end_speed;
    int32_t growth = slope_of(ticks, (uint16_t)(top - low));
    int32_t limit = flat_limit(ticks, low);

    *stays = growth >> 2 < limit;
    if (*stays) {
        return curve_flat_now(ticks, top, growth >= limit);
    }
    return !faster && growth >> 2 < flat_limit(ticks, top)
               ? curve_flat_now(ticks, top, true)
               : CURVE_FLAT_NOT;
}

// T^2, the distance of two steps, without its highest bits.
static struct wide step_of(const struct curve_place *at)
{
    return (struct wide){.high = (int32_t)((at->step << 8) | (at->step_low >> 8)),
                         .low = (uint8_t)at->step_low};
}

void curve_flat_enter(struct curve_flat *flat,
                      const struct curve_place *at,
                      uint16_t interval_ticks)
{
    uint32_t half = (uint32_t)(int32_t)at->half;
    int32_t half_slope_growth = (int32_t)multiply_u32_u16(half, interval_ticks);

    // Each number is stored as soon as it is known, so that few of them take up stack.
    flat->residual = at->residual;
    flat->twice_half = (int16_t)(2 * at->half);
    flat->top = (uint16_t)(interval_ticks - 1u);
    flat->slope_growth = 2 * half_slope_growth;
    flat->gain_growth = wide_times(wide_from_int32(flat->slope_growth), interval_ticks);

    struct wide ahead = wide_from_int32(half_slope_growth - at->half);
    struct wide mean = wide_add(at->slope, ahead);
    flat->difference = wide_add(mean, ahead);
    flat->gain = wide_sub(wide_times(mean, interval_ticks), step_of(at));
}

void curve_flat_leave(const struct curve_flat *flat, struct curve_place *at)
{
    at->residual = flat->residual;
    at->slope = wide_sub(flat->difference,
                         wide_from_int32(flat->slope_growth - flat->twice_half));
    at->half = (int16_t)(flat->twice_half >> 1);
}

#if defined(__AVR__)

_Static_assert(sizeof(struct progress) == 4 && offsetof(struct progress, left) == 2,
               "known to curve_flat_steps.S");

// In curve_flat_steps.S: make up to `count` steps. The entries' low bytes go to `low` and behind;
// only the low byte of the address advances, so that the ring wraps.
struct progress curve_flat_narrow(struct curve_flat *flat,
                                  volatile uint8_t *low,
                                  uint8_t count);
struct progress curve_flat_wide(struct curve_flat *flat,
                                volatile uint8_t *low,
                                uint8_t count);

static inline struct progress make_flat_steps(struct curve_flat *flat,
                                              bool narrow,
                                              volatile uint8_t *lows,
                                              uint8_t slot,
                                              uint8_t count)
{
    return FEATURE_NARROW_CURVES && narrow ? curve_flat_narrow(flat, &lows[slot], count)
                                           : curve_flat_wide(flat, &lows[slot], count);
}

// Store `value` in `count` slots from highs[slot] on. Only the low byte of the address advances:
// the ring's arrays lie on 256-byte boundaries, so that the slots wrap. Four stores a pass take 4
// cycles an entry.
static inline void fill_highs(volatile uint8_t *highs,
                              uint8_t slot,
                              uint8_t count,
                              uint8_t value)
{
    volatile uint8_t *at = &highs[slot];
    uint8_t fours = count >> 2;

    __asm__ volatile("andi %[rest], 3\n\t"
                     "breq 2f\n"
                     "1: st %a[at], %[value]\n\t"
                     "inc %A[at]\n\t"
                     "dec %[rest]\n\t"
                     "brne 1b\n"
                     "2: tst %[fours]\n\t"
                     "breq 4f\n"
                     "3: st %a[at], %[value]\n\t"
                     "inc %A[at]\n\t"
                     "st %a[at], %[value]\n\t"
                     "inc %A[at]\n\t"
                     "st %a[at], %[value]\n\t"
                     "inc %A[at]\n\t"
                     "st %a[at], %[value]\n\t"
                     "inc %A[at]\n\t"
                     "dec %[fours]\n\t"
                     "brne 3b\n"
                     "4:\n\t"
                     : [at] "+e"(at), [rest] "+d"(count), [fours] "+r"(fours)
                     : [value] "r"(value)
                     : "memory");
}

#else

static inline void fill_highs(volatile uint8_t *highs,
                              uint8_t slot,
                              uint8_t count,
                              uint8_t value)
{
    for (; count != 0; count--) {
        highs[slot] = value;
        slot++;
    }
}

// Make q one tick longer.
static void interval_up(struct curve_flat *flat)
{
    struct wide slope_growth = wide_from_int32(flat->slope_growth);
    struct wide twice_half = wide_from_int32(flat->twice_half);

    flat->difference = wide_add(flat->difference, twice_half);
    flat->gain = wide_add(flat->gain, flat->difference);
    flat->gain_growth = wide_add(
        wide_add(flat->gain_growth, wide_add(slope_growth, slope_growth)), twice_half);
    flat->slope_growth += flat->twice_half;
    flat->top++;
}

// Make q one tick shorter.
static void interval_down(struct curve_flat *flat)
{
    struct wide slope_growth = wide_from_int32(flat->slope_growth);
    struct wide twice_half = wide_from_int32(flat->twice_half);

    flat->gain = wide_sub(flat->gain, flat->difference);
    flat->difference = wide_sub(flat->difference, twice_half);
    flat->gain_growth = wide_add(
        wide_sub(flat->gain_growth, wide_add(slope_growth, slope_growth)), twice_half);
    flat->slope_growth -= flat->twice_half;
    flat->top--;
}

// Move q by one tick if the next step fits neither q nor q + 1. Returns the move, 0 for none.
static int8_t move_interval(struct curve_flat *flat)
{
    struct wide value = wide_add(flat->residual, flat->gain);
    struct wide twice_half = wide_from_int32(flat->twice_half);

    if (wide_add(value, wide_add(flat->difference, twice_half)).high < 0) {
        interval_up(flat);
        return 1;
    }
    if (value.high >= 0 && wide_sub(value, flat->difference).high >= 0) {
        interval_down(flat);
        return -1;
    }
    return 0;
}

// Move q until the next step takes q or q + 1. False when the high byte of q - 1 has changed, which
// ends the loop over the steps.
static bool fit_interval(struct curve_flat *flat, uint8_t left, uint16_t *extra_ticks)
{
    uint8_t high = (uint8_t)(flat->top >> 8);
    int8_t moved = 1;

    while (moved != 0 && flat->top >> 8 == high) {
        moved = move_interval(flat);
        *extra_ticks = (uint16_t)(*extra_ticks + moved * left);
    }
    return moved == 0;
}

// The steps as curve_flat_steps.S makes them, for every other processor.
static struct progress make_flat_steps(struct curve_flat *flat,
                                       bool narrow,
                                       volatile uint8_t *lows,
                                       uint8_t slot,
                                       uint8_t count)
{
    struct progress progress = {0};

    (void)narrow;
    for (; count != 0 && fit_interval(flat, count, &progress.extra_ticks); count--) {
        uint8_t low = (uint8_t)flat->top;
        struct wide value = wide_add(flat->residual, flat->gain);
        if (value.high < 0) {
            flat->difference =
                wide_add(flat->difference, wide_from_int32(flat->twice_half));
            flat->gain = wide_add(flat->gain, wide_from_int32(flat->slope_growth));
            value = wide_add(value, flat->difference);
            progress.extra_ticks++;
            progress.carried = low == 0xFFu ? 1u : progress.carried;
            low++;
        }
        flat->residual = value;
        flat->gain = wide_add(flat->gain, flat->gain_growth);
        flat->difference =
            wide_add(flat->difference, wide_from_int32(flat->slope_growth));
        lows[slot] = low;
        slot++;
    }
    progress.left = count;
    return progress;
}

#endif

// Give each entry whose low byte is 0 by a carry the next high byte. The first entry's high byte is
// not in the ring yet but in *made.
static void carry_highs(struct step_ring *ring,
                        uint8_t slot,
                        uint8_t count,
                        uint8_t first_slot,
                        struct curve_made *made)
{
    BY_POINTER_SMALL(ring);
    for (; count != 0; count--) {
        if (ring->low[slot] != 0) {
            // as filled
        } else if (slot == first_slot) {
            made->first_high++;
        } else {
            ring->high[slot]++;
        }
        slot++;
    }
}

// Add to *made `count` steps from `slot` on that were begun where q - 1 was `top`. Returns how many
// of them were not made.
static inline uint8_t note_made(const struct curve_flat *flat,
                                const struct progress *progress,
                                struct step_ring *ring,
                                uint16_t top,
                                uint8_t slot,
                                uint8_t count,
                                uint8_t first_slot,
                                struct curve_made *made)
{
    uint8_t done = (uint8_t)(count - progress->left);
    // Each move of q was counted for the steps that are left, too. Those steps begin anew with the
    // moved q, so that their share is taken back.
    uint16_t moved = (uint16_t)(progress->left * (uint16_t)(flat->top - top));
    uint32_t extra_ticks = (uint32_t)(int32_t)(int16_t)(progress->extra_ticks - moved);

    made->ticks += multiply_u32_u16((uint32_t)top + 1u, done) + extra_ticks;
    if (progress->carried != 0) {
        carry_highs(ring, slot, done, first_slot, made);
    }
    return progress->left;
}

// Make `count` steps of a batch from `slot` on, as many at a time as have the same high byte.
static inline void make_by_highs(struct curve_flat *flat,
                                 bool narrow,
                                 struct step_ring *ring,
                                 uint8_t slot,
                                 uint8_t count,
                                 uint8_t first_slot,
                                 struct curve_made *made)
{
    do {
        uint16_t top = flat->top;
        uint8_t high = (uint8_t)(top >> 8);
        if (slot == first_slot) {
            made->first_high = high;
            fill_highs(ring->high, (uint8_t)(slot + 1u), (uint8_t)(count - 1u), high);
        } else {
            fill_highs(ring->high, slot, count, high);
        }
        struct progress progress = make_flat_steps(flat, narrow, ring->low, slot, count);
        uint8_t left =
            note_made(flat, &progress, ring, top, slot, count, first_slot, made);
        slot = (uint8_t)(slot + count - left);
        count = left;
    } while (count != 0);
}

void curve_flat_burst(struct curve_flat *flat,
                      bool narrow,
                      struct step_ring *ring,
                      uint8_t slot,
                      uint8_t count,
                      struct curve_made *made)
{
    *made = (struct curve_made){.steps = count};
    make_by_highs(flat, narrow, ring, slot, count, slot, made);
}

APART uint16_t curve_flat_next(struct curve_flat *flat, bool narrow)
{
    volatile uint8_t low;
    struct progress progress;
    uint16_t top;

    do {
        top = flat->top;
        progress = make_flat_steps(flat, narrow, &low, 0, 1);
    } while (progress.left != 0);
    return (uint16_t)(top + 1u + progress.extra_ticks);
}
