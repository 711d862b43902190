// SPDX-License-Identifier: MIT
// hal/step_timer.h with a virtual interrupt. The interrupt is served at the start of the newest
// loaded period, and loads the period behind that one.
#include "hal/step_timer.h"

#include "fakes/board.h"
#include "fakes/board_parts.h"
#include "hal/clock.h"

struct timer {
    struct step_engine engine;
    uint32_t start_ticks;   // start of the newest loaded period
    uint32_t running_ticks; // start of the period before that one
    uint32_t end_ticks;     // end of the newest loaded period
    struct step_load held;  // the timer's registers
    bool pulsed;            // the timer's compare flag
    bool late;
    bool stopped; // the timer's interrupt is off
};

struct fake_axis fake_axes[CONFIG_AXES];
static struct timer timers[CONFIG_AXES];
// On the AVR the rings lie where the board's rings do: elsewhere the gap before them would take
// memory from the stack.
#if defined(__AVR__)
#define AT_START_OF_RAM __attribute__((section(".step_rings,\"aw\",@nobits;")))
#else
#define AT_START_OF_RAM
#endif
static struct step_ring rings[CONFIG_AXES] AT_START_OF_RAM;
static bool started;

void fake_timers_power_on(void)
{
    started = false;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        timers[i] = (struct timer){.late = false};
        fake_axes[i] = (struct fake_axis){.steps = 0};
        step_engine_reset(&timers[i].engine, &rings[i]);
    }
}

void step_timer_start(void)
{
    started = true;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        bool negative = timers[i].engine.negative;
        step_engine_reset(&timers[i].engine, &rings[i]);
        timers[i].engine.negative = negative;
        timers[i].held = (struct step_load){.top_ticks = STEP_IDLE_TICKS - 1u};
        timers[i].pulsed = false;
        timers[i].late = false;
        timers[i].stopped = false;
        timers[i].running_ticks = fake_now_ticks();
        timers[i].start_ticks = fake_now_ticks() + STEP_IDLE_TICKS;
        timers[i].end_ticks = timers[i].start_ticks + STEP_IDLE_TICKS;
    }
}

static void note_step(struct fake_axis *axis, bool negative, uint32_t ticks)
{
    axis->steps += negative ? -1 : 1;
    axis->last_step_ticks = ticks;
    if (axis->first_step_ticks == 0) {
        axis->first_step_ticks = ticks;
    }
}

// An idle engine with nothing in its ring leaves the registers as they are (step_isr.S).
static bool nothing_to_load(uint8_t i)
{
    const struct step_engine *engine = &timers[i].engine;

    return engine->state == STEP_ENGINE_IDLE && engine->left == 0 &&
           rings[i].high[engine->tail] == STEP_HIGH_EMPTY;
}

// What the interrupt loads; of a parked axis only the count of idle periods goes on.
static struct step_load next_load(struct timer *timer, const struct step_ring *ring)
{
    if (timer->engine.state == STEP_ENGINE_PARKED) {
        timer->engine.idle_count++;
        return timer->held;
    }
    return step_engine_next(&timer->engine, ring);
}

static void interrupt(uint8_t i)
{
    struct timer *timer = &timers[i];
    bool loads = !nothing_to_load(i);
    struct step_load load = next_load(timer, &rings[i]);

    if (loads) {
        timer->held = load;
    }
    load = timer->held;
    if (load.pulse) {
        timer->pulsed = true;
        note_step(&fake_axes[i],
                  timer->engine.negative,
                  timer->end_ticks + STEP_TIMER_EDGE_TICKS);
    }
    timer->running_ticks = timer->start_ticks;
    timer->start_ticks = timer->end_ticks;
    timer->end_ticks += (uint32_t)load.top_ticks + 1u;
}

void fake_timers_pass_to(uint32_t now_ticks)
{
    for (uint8_t i = 0; started && i < CONFIG_AXES; i++) {
        while (!timers[i].stopped && (int32_t)(timers[i].start_ticks - now_ticks) <= 0) {
            interrupt(i);
        }
    }
}

uint32_t fake_timers_period_start(uint8_t axis)
{
    return timers[axis].running_ticks;
}

void fake_underrun(uint8_t axis)
{
    timers[axis].late = true;
    timers[axis].stopped = true;
    timers[axis].engine.state = STEP_ENGINE_HALTED;
}

void fake_missed_period(uint8_t axis)
{
    struct timer *timer = &timers[axis];
    uint32_t ticks = timer->end_ticks - timer->start_ticks;

    timer->running_ticks = timer->start_ticks;
    timer->start_ticks = timer->end_ticks;
    timer->end_ticks += ticks;
}

struct step_ring *step_timer_ring(uint8_t axis)
{
    return &rings[axis];
}

struct pulse_train *step_timer_trains(uint8_t axis)
{
    return timers[axis].engine.trains;
}

void step_timer_sample(uint8_t axis, struct engine_sample *sample)
{
    *sample = step_engine_sample(&timers[axis].engine);
}

// A look takes time, so that the clock counts between two of them.
#define LOOK_TICKS 9u

bool step_timer_look(uint8_t axis, struct step_timer_look *look)
{
    if (timers[axis].engine.state == STEP_ENGINE_PARKED) {
        return false;
    }
    fake_pass(LOOK_TICKS);
    *look = (struct step_timer_look){
        .sample = step_engine_sample(&timers[axis].engine),
        .counter = (uint16_t)(fake_now_ticks() - timers[axis].running_ticks),
        .units = clock_now_units(),
    };
    return true;
}

uint8_t step_timer_tail(uint8_t axis)
{
    return timers[axis].engine.tail;
}

enum step_engine_state step_timer_state(uint8_t axis)
{
    return (enum step_engine_state)timers[axis].engine.state;
}

static uint32_t slow_publish_ticks; // pass before the next line is published

void fake_slow_publish(uint32_t ticks)
{
    slow_publish_ticks = ticks;
}

bool step_timer_publish(uint8_t axis, uint8_t slot, uint16_t idle_count)
{
    if (slow_publish_ticks != 0) {
        uint32_t ticks = slow_publish_ticks;
        slow_publish_ticks = 0;
        fake_pass(ticks);
    }
    if (timers[axis].engine.idle_count != idle_count) {
        return false;
    }
    rings[axis].high[slot] = STEP_HIGH_COMMAND;
    return true;
}

static bool is_parked(uint8_t axis)
{
    return timers[axis].engine.state == STEP_ENGINE_PARKED;
}

bool step_timer_park(uint8_t axis, uint16_t idle_count)
{
    struct step_engine *engine = &timers[axis].engine;

    if (engine->state != STEP_ENGINE_IDLE || engine->idle_count != idle_count) {
        return false;
    }
    engine->state = STEP_ENGINE_PARKED;
    return true;
}

bool step_timer_unpark(uint8_t axis)
{
    struct step_engine *engine = &timers[axis].engine;

    if (is_parked(axis) && !engine->stop) {
        engine->state = STEP_ENGINE_IDLE;
    }
    return !is_parked(axis);
}

void step_timer_halt_at(uint8_t which)
{
    if (is_parked(which)) {
        step_engine_halt_soon(&timers[which].engine);
    } else {
        step_engine_halt(&timers[which].engine);
    }
}

bool step_timer_settle(uint8_t axis, uint8_t *slot)
{
    bool parked = is_parked(axis);
    bool settled = step_engine_settle(&timers[axis].engine, &rings[axis], slot);

    if (parked) {
        timers[axis].engine.state = STEP_ENGINE_PARKED;
    }
    return settled;
}

bool step_timer_pulsed(uint8_t axis)
{
    bool pulsed = timers[axis].pulsed;

    timers[axis].pulsed = false;
    return pulsed;
}

void step_timer_silence(uint8_t axis)
{
    step_timer_halt(axis);
    timers[axis].held.pulse = false;
}

void fake_stray_steps(uint8_t axis)
{
    timers[axis].held = (struct step_load){.top_ticks = 20000, .pulse = true};
}

bool step_timer_underrun(void)
{
    bool late = false;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        late = late || timers[i].late;
    }
    return late;
}

bool step_timer_take_underrun(uint8_t axis)
{
    bool late = timers[axis].late;

    timers[axis].late = false;
    return late;
}

void step_timer_enable(uint8_t axis, bool on)
{
    fake_axes[axis].enabled = on;
}

uint8_t step_timer_heartbeat(uint8_t axis)
{
    const struct step_engine *engine = &timers[axis].engine;

    return (uint8_t)(engine->tail + (uint8_t)engine->left + (uint8_t)engine->idle_count);
}

void fake_hang_axis(uint8_t axis)
{
    timers[axis].stopped = true;
}
