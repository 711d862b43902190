// SPDX-License-Identifier: MIT
#include "avr/hal/step_parked.h"

#include "config.h" // CONFIG_AXES

#if CONFIG_AXES > 1
#include <avr/io.h>
#include <stdint.h>
#include <util/atomic.h>

#include "avr/hal/clock_units.h" // clock_look
#include "avr/hal/step_isr.h"    // step_engines
#include "hal/clock.h"           // CLOCK_UNIT_TICKS
#include "ring/parked.h"         // parked_*

_Static_assert(PARKED_UNIT_TICKS == CLOCK_UNIT_TICKS, "the unit of the coarse clock");

// Of each axis, as parked_base() gave it when the axis was parked last.
static uint32_t parked_bases[CONFIG_AXES];

// The counter of an axis that no step interrupt serves, and the coarse clock at the same instant.
struct place {
    uint16_t counter;
    uint32_t units;
};

static struct place place_of(uint8_t axis)
{
#define BOARD_AXIS(number, timer) [number] = &TCNT##timer,
    static const volatile uint16_t *const counters[CONFIG_AXES] = {
#include BOARD_FILE
    };
    const volatile uint16_t *from = counters[axis];
    struct place place;
    struct clock_look look;

    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        place.counter = *from;
        look = clock_look();
    }
    place.units = clock_look_units(&look);
    return place;
}

uint16_t step_parked_idle_count(uint8_t axis)
{
    struct place place = place_of(axis);

    return parked_count(parked_bases[axis], place.units, place.counter);
}

uint16_t step_parked_idle_count_at(uint8_t axis, uint16_t units, uint16_t captured)
{
    struct clock_look look;

    // The axis may run by now: reading its counter would disturb TEMP. Without it the count of now
    // is one more at most, which is still a count behind the edge.
    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        look = clock_look();
    }
    uint16_t now_count = parked_count(parked_bases[axis], clock_look_units(&look), 0);
    return parked_count_at(parked_bases[axis], units, captured, now_count);
}

// Switch the overflow interrupt of an axis on or off, and leave TEMP as its handler expects it. 9
// cycles with interrupts off.
static void serve_overflow(uint8_t axis, bool on)
{
    uint8_t bit = on ? _BV(TOIE1) : 0;
    uint8_t train_high = step_engines[axis].train_high;

#define BOARD_AXIS(number, timer)                                                        \
    if (axis == (number)) {                                                              \
        OCR##timer##AH = train_high;                                                     \
        ATOMIC_BLOCK(ATOMIC_FORCEON)                                                     \
        {                                                                                \
            TIMSK##timer = (uint8_t)((TIMSK##timer & ~_BV(TOIE##timer)) | bit);          \
        }                                                                                \
    }
#include BOARD_FILE
}

// The same as on, unless a period has begun whose overflow nobody has served: then false. 14 cycles
// with interrupts off.
// NOLINTNEXTLINE(readability-function-*): one block for each timer of the board file
static bool serve_from_here(uint8_t axis)
{
    uint8_t train_high = step_engines[axis].train_high;
    bool served = false;

#define BOARD_AXIS(number, timer)                                                        \
    if (axis == (number)) {                                                              \
        OCR##timer##AH = train_high;                                                     \
        ATOMIC_BLOCK(ATOMIC_FORCEON)                                                     \
        {                                                                                \
            if ((TIFR##timer & _BV(TOV##timer)) == 0) {                                  \
                TIMSK##timer |= (uint8_t)_BV(TOIE##timer);                               \
                served = true;                                                           \
            }                                                                            \
        }                                                                                \
    }
#include BOARD_FILE
    return served;
}

// True when a period began whose overflow nobody has served.
static bool overflowed(uint8_t axis)
{
    uint8_t flags = 0;

#define BOARD_AXIS(number, timer)                                                        \
    if (axis == (number)) {                                                              \
        flags = TIFR##timer;                                                             \
    }
#include BOARD_FILE
    return (flags & _BV(TOV1)) != 0;
}

// Forget the overflows of a parked axis.
static void clear_overflow(uint8_t axis)
{
#define BOARD_AXIS(number, timer)                                                        \
    if (axis == (number)) {                                                              \
        TIFR##timer = (uint8_t)_BV(TOV##timer);                                          \
    }
#include BOARD_FILE
}

// The axis has been idle since idle_count and no halt came, the overflow interrupt being off.
static bool still_idle(uint8_t axis, uint16_t idle_count)
{
    const struct step_engine *engine = &step_engines[axis];

    return engine->state == STEP_ENGINE_IDLE && engine->idle_count == idle_count &&
           !overflowed(axis);
}

// With the overflow interrupt off the periods stand still for the account, so that there is time to
// look at them; an emergency stop may come at any instant. Before the last look it gives way to the
// compare A interrupt or notes a halt; behind it, it finds a parked axis.
bool step_park(uint8_t axis, uint16_t idle_count)
{
    struct step_engine *engine = &step_engines[axis];
    bool parked = false;

    if (engine->state != STEP_ENGINE_IDLE) {
        return false;
    }
    serve_overflow(axis, false);
    struct place place = place_of(axis);

    parked_bases[axis] = parked_base(place.units, place.counter, idle_count);
    bool fits = still_idle(axis, idle_count);
    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        if (fits && engine->state == STEP_ENGINE_IDLE && !engine->stop) {
            engine->state = STEP_ENGINE_PARKED;
            parked = true;
        }
    }
    if (!parked && engine->state == STEP_ENGINE_IDLE) {
        serve_overflow(axis, true);
    }
    return parked;
}

// The count must say what the overflow interrupt goes on from. It does if no period begins between
// the look at the clocks and the instant at which the interrupt is switched on. The flag shows a
// period that begins, however long the main loop is held there, and the look is taken again.
void step_unpark(uint8_t axis)
{
    struct step_engine *engine = &step_engines[axis];

    do {
        clear_overflow(axis);
        // Until the overflow interrupt is on, only a capture reads the count, and not of a parked
        // axis.
        engine->idle_count = step_parked_idle_count(axis);
    } while (!serve_from_here(axis));
    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        if (engine->state == STEP_ENGINE_PARKED) {
            engine->state = STEP_ENGINE_IDLE;
        }
    }
}
#endif
