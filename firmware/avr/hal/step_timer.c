// SPDX-License-Identifier: MIT
// The step timers are the 16-bit timers in fast PWM mode 15: OCRnA holds TOP, and STEP is output
// OCnB, inverting.
#include "hal/step_timer.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/atomic.h>

#include "avr/hal/pins.h"        // pins_write_direction
#include "avr/hal/step_isr.h"    // what the assembly half needs
#include "avr/hal/step_parked.h" // step_is_parked
#include "config.h"              // CONFIG_*
#include "hal/clock.h"           // clock_now_units

#if CONFIG_AXES > 1
#define FORGET_LAST(axis) (step_isr_last[axis] = 0)
#else
#define FORGET_LAST(axis) ((void)0)
#endif

static volatile uint8_t late_axes; // bit n: the step interrupt of axis n came too late

struct step_ring *step_timer_ring(uint8_t axis)
{
    return &step_rings[CONFIG_INDEX(axis)];
}

// The rare cases of the step interrupt: a command, or the end of the entries. The assembly half
// calls this handler with interrupts on, except for this timer's own. The handler turns interrupts
// off only while it writes the compare registers, because TEMP is shared with the capture's reads,
// and while it writes the port, because other axes share it. Budget: 320 cycles, 50 of them with
// interrupts off. The entries around a command are long enough for it (feed.c).
#define COMMAND_HANDLER(axis, timer)                                                     \
    void step_isr_command_##axis(void);                                                  \
    void step_isr_command_##axis(void)                                                   \
    {                                                                                    \
        struct step_load load =                                                          \
            step_engine_take(&step_engines[axis], &step_rings[axis]);                    \
        uint16_t edge_ticks = load.pulse ? CONFIG_PULSE_LOW_TICKS : QUIET_TICKS;         \
        ATOMIC_BLOCK(ATOMIC_FORCEON)                                                     \
        {                                                                                \
            OCR##timer##B = edge_ticks;                                                  \
            OCR##timer##A = load.top_ticks;                                              \
            FORGET_LAST(axis);                                                           \
            /* Leave TEMP ready for a pulse train that comes next (step_isr.S). */       \
            OCR##timer##AH = step_engines[axis].train_high;                              \
            step_engine_count(&step_engines[axis], &load);                               \
            /* A stale flag would count this period twice: see halt in step_isr.S. */    \
            TIFR##timer = (uint8_t)_BV(OCF##timer##A);                                   \
        }                                                                                \
        if (load.reverses) {                                                             \
            ATOMIC_BLOCK(ATOMIC_FORCEON)                                                 \
            {                                                                            \
                pins_write_direction((axis), step_engines[axis].negative);               \
            }                                                                            \
        }                                                                                \
    }
// The work of a halted axis's compare A interrupt (halted_handler in step_isr.S). Every idle period
// loads the registers anew, although they should hold these values already, so that no STEP edge
// can come from a register that was overwritten. Clearing the overflow flag stands in for the
// overflow interrupt, which is off: a capture tells periods apart by this flag.
#define LOAD_IDLE(axis, timer)                                                           \
    do {                                                                                 \
        OCR##timer##B = QUIET_TICKS;                                                     \
        OCR##timer##A = STEP_IDLE_TICKS - 1u;                                            \
        TIFR##timer = (uint8_t)_BV(TOV##timer);                                          \
        step_engines[axis].state = STEP_ENGINE_HALTED;                                   \
        step_engines[axis].idle_count++;                                                 \
    } while (0)
// Enable the compare A interrupt in place of the overflow interrupt.
#define GIVE_WAY(timer)                                                                  \
    TIMSK##timer = (uint8_t)((TIMSK##timer & ~_BV(TOIE##timer)) | _BV(OCIE##timer##A))
// The interrupts that serve an axis. A single axis is never parked.
#if CONFIG_AXES == 1
#define SERVED(timer) 0xFFu
#else
#define SERVED(timer) (_BV(TOIE##timer) | _BV(OCIE##timer##A))
#endif
// Halt an axis: from now on its compare A interrupt serves the axis and loads idle periods. The
// compare A flag is stale unless the end of this period has set it. If the period ends while the
// flag is being cleared, the idle period is loaded here. The halt does the same in every state of
// the engine, because the engine's state does not tell what the timer is doing.
//
// A command handler (step_isr.S) masks all interrupts of its timer while it takes entries. When the
// halt interrupts such a handler, the handler itself gives way as soon as it is done.
//
// Interrupts are off for 25 cycles: when the period ends meanwhile, the compare A interrupt must
// still load the next one before the shortest interval is over. The engine's fields are changed
// with interrupts on, because the overflow interrupt, which also changes them, is off by then.
//
// A parked axis has nothing to give up, and its timer no interrupt either: the halt is noted, so
// that the axis is not unparked before it is settled.
//
//     TOV   compare A
//     no    stale, cleared: the next end sets it
//     yes   set at the same instant: it comes as soon as interrupts are on
//     yes   cleared: the end came between the two looks
#define HALT_AXIS(axis, timer)                                                           \
    if (CONFIG_AXES == 1 || which == (axis)) {                                           \
        bool taking = false;                                                             \
        ATOMIC_BLOCK(ATOMIC_FORCEON)                                                     \
        {                                                                                \
            if ((TIMSK##timer & SERVED(timer)) == 0) {                                   \
                step_engine_halt_soon(&step_engines[axis]);                              \
                taking = true;                                                           \
            } else {                                                                     \
                GIVE_WAY(timer);                                                         \
                if ((TIFR##timer & _BV(TOV##timer)) == 0) {                              \
                    TIFR##timer = (uint8_t)_BV(OCF##timer##A);                           \
                    if ((TIFR##timer & (_BV(TOV##timer) | _BV(OCF##timer##A))) ==        \
                        _BV(TOV##timer)) {                                               \
                        LOAD_IDLE(axis, timer);                                          \
                    }                                                                    \
                }                                                                        \
            }                                                                            \
        }                                                                                \
        if (!taking) {                                                                   \
            step_engine_halt(&step_engines[axis]);                                       \
        }                                                                                \
    }
// An underrun: the next period began before its successor was loaded, so that the step after it
// would be late. The assembly half has already taken the pin from the timer, before that edge.
// Called with interrupts off.
#define LATE_HANDLER(axis, timer)                                                        \
    void step_isr_late_##axis(void);                                                     \
    void step_isr_late_##axis(void)                                                      \
    {                                                                                    \
        GIVE_WAY(timer);                                                                 \
        step_engine_halt(&step_engines[axis]);                                           \
        late_axes |= (uint8_t)(1u << (axis));                                            \
    }
#define BOARD_AXIS(axis, timer) COMMAND_HANDLER(axis, timer) LATE_HANDLER(axis, timer)
#include BOARD_FILE

// NOLINTNEXTLINE(readability-function-*): one block for each timer of the board file
void step_timer_halt_at(uint8_t which){
#define BOARD_AXIS(axis, timer) HALT_AXIS(axis, timer)
#include BOARD_FILE
}

// Load the compare registers in mode 0, where they are not buffered; then enter mode 15, stopped.
#define PREPARE_FUNCTION(timer)                                                          \
    static void prepare_##timer(void)                                                    \
    {                                                                                    \
        TCCR##timer##B = 0;                                                              \
        TCCR##timer##A = 0;                                                              \
        OCR##timer##A = STEP_IDLE_TICKS - 1u;                                            \
        OCR##timer##B = QUIET_TICKS;                                                     \
        TCCR##timer##A = (uint8_t)(_BV(COM##timer##B1) | _BV(COM##timer##B0) |           \
                                   _BV(WGM##timer##1) | _BV(WGM##timer##0));             \
        TCCR##timer##B = STOPPED_MODE_15;                                                \
        TIFR##timer = 0xFF;                                                              \
        TIMSK##timer = (uint8_t)_BV(TOIE##timer);                                        \
    }
#define STOPPED_MODE_15         ((uint8_t)(_BV(WGM13) | _BV(WGM12) | _BV(ICES1)))
#define RUNNING_MODE_15         ((uint8_t)(STOPPED_MODE_15 | _BV(CS10)))
#define BOARD_AXIS(axis, timer) PREPARE_FUNCTION(timer)
#include BOARD_FILE

// The stores that start the timers follow each other two cycles apart. Each timer therefore starts
// from a count that is two cycles further on, and all timers count in phase.
#define START_CYCLES 2u
static void start_in_phase(void)
{
    uint8_t run = RUNNING_MODE_15;

#define BOARD_AXIS(axis, timer) TCNT##timer = (axis) * START_CYCLES;
#include BOARD_FILE
#define BOARD_AXIS(axis, timer)                                                          \
    if ((axis) == CONFIG_PIXEL_CLOCK_AXIS) {                                             \
        TIMSK##timer |= (uint8_t)_BV(ICIE##timer);                                       \
    }
#include BOARD_FILE
#define BOARD_AXIS(axis, timer) TCCR##timer##B = run;
#include BOARD_FILE
}

void step_timer_start(void)
{
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        for (uint8_t axis = 0; axis < CONFIG_AXES; axis++) {
            bool negative = step_engines[axis].negative;
            step_engine_reset(&step_engines[axis], &step_rings[axis]);
            step_engines[axis].negative = negative;
        }
        late_axes = 0;
#define BOARD_AXIS(axis, timer) prepare_##timer();
#include BOARD_FILE
        start_in_phase();
    }
}

#if CONFIG_AXES > 1
bool step_timer_park(uint8_t axis, uint16_t idle_count)
{
    bool parked = step_park(axis, idle_count);

    if (!parked && step_engines[axis].state == STEP_ENGINE_IDLE &&
        step_engines[axis].stop) {
        step_timer_halt(axis);
    }
    return parked;
}

bool step_timer_unpark(uint8_t axis)
{
    if (!step_is_parked(axis)) {
        return true;
    }
    if (step_engines[axis].stop) {
        return false;
    }
    step_unpark(axis);
    if (step_engines[axis].stop) {
        step_timer_halt(axis);
    }
    return !step_engines[axis].stop;
}
#endif

struct pulse_train *step_timer_trains(uint8_t axis)
{
    return step_engines[CONFIG_INDEX(axis)].trains;
}

void step_timer_sample(uint8_t axis, struct engine_sample *sample)
{
    *sample = step_isr_sample(axis);
    if (step_is_parked(axis)) {
        sample->idle_count = step_parked_idle_count(axis);
    }
}

#if CONFIG_AXES > 1
// Tries of step_timer_look(): an idle period that is loaded in between spoils one, and so does
// traffic that saturates the serial line. Beside steps of 64 ticks one try in three meets a period
// that begins: with four tries a check in fifty would say nothing.
#define LOOKS 16u

// The counter, whether the period that it counts has been served, and what its interrupt has
// consumed. A read of the counter overwrites TEMP, which the axis's handler expects as step_isr.S
// says. 17 cycles with interrupts off.
#define LOOK_CASE(number, timer)                                                         \
    case (number):                                                                       \
        ATOMIC_BLOCK(ATOMIC_FORCEON)                                                     \
        {                                                                                \
            counter = TCNT##timer;                                                       \
            OCR##timer##AH = step_engines[number].train_high;                            \
            flags = TIFR##timer;                                                         \
            unit = TCNT0;                                                                \
            tail = step_engines[number].tail;                                            \
            left = step_engines[number].left;                                            \
        }                                                                                \
        break;
// NOLINTNEXTLINE(readability-function-*): one block for each timer of the board file
static bool look_once(uint8_t axis, struct step_timer_look *look)
{
    const struct step_engine *engine = step_isr_engine(axis);
    uint32_t before_units = clock_now_units();
    struct engine_sample before = step_isr_sample(axis);
    uint16_t counter = 0;
    uint8_t flags = 0;
    uint8_t unit = 0;
    uint8_t tail = 0;
    int8_t left = 0;

    switch (CONFIG_INDEX(axis)) {
#define BOARD_AXIS(axis, timer) LOOK_CASE(axis, timer)
#include BOARD_FILE
    default:
        break;
    }
    struct engine_sample after = step_isr_sample(axis);

    // An emergency stop may come from here on: what it cuts is not of this look.
    look->sample = step_engine_sample_of(
        tail, left, after.cut ? engine->cut : (int8_t)0, after.idle_count);
    look->counter = counter;
    look->units = clock_now_units();
    // Interrupts can hold the main loop for longer than eight bits count.
    bool held = look->units - before_units > UINT8_MAX;
    look->units -= (uint8_t)((uint8_t)look->units - unit);
    return !held && (flags & _BV(TOV1)) == 0 && before.idle_count == after.idle_count &&
           before.cut == after.cut;
}

bool step_timer_look(uint8_t axis, struct step_timer_look *look)
{
    uint8_t tries = step_is_parked(axis) ? 0 : LOOKS;

    while (tries != 0 && !look_once(axis, look)) {
        tries--;
    }
    return tries != 0;
}
#endif

uint8_t step_timer_tail(uint8_t axis)
{
    return step_engines[CONFIG_INDEX(axis)].tail;
}

enum step_engine_state step_timer_state(uint8_t axis)
{
    return (enum step_engine_state)step_engines[CONFIG_INDEX(axis)].state;
}

uint8_t step_timer_heartbeat(uint8_t axis)
{
    const struct step_engine *engine = &step_engines[CONFIG_INDEX(axis)];

    return (uint8_t)(engine->tail + (uint8_t)engine->left + (uint8_t)engine->idle_count);
}

bool step_timer_publish(uint8_t axis, uint8_t slot, uint16_t idle_count)
{
    const struct step_engine *engine = step_isr_engine(axis);
    bool published = false;

    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        if (engine->idle_count == idle_count) {
            step_rings[CONFIG_INDEX(axis)].high[slot] = STEP_HIGH_COMMAND;
            published = true;
        }
    }
    return published;
}

// Let the overflow interrupt take over again from the compare A interrupt of a halted axis.
#define RESUME_CASE(number, timer)                                                       \
    case (number):                                                                       \
        TIMSK##timer =                                                                   \
            (uint8_t)((TIMSK##timer & ~_BV(OCIE##timer##A)) | _BV(TOIE##timer));         \
        break;
static void resume_axis(uint8_t axis)
{
    switch (CONFIG_INDEX(axis)) {
#define BOARD_AXIS(axis, timer) RESUME_CASE(axis, timer)
#include BOARD_FILE
    default:
        break;
    }
}

bool step_timer_settle(uint8_t axis, uint8_t *slot)
{
    bool settled = false;

    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
    {
        bool parked = step_is_parked(axis);
        settled = step_engine_settle(
            &step_engines[CONFIG_INDEX(axis)], &step_rings[CONFIG_INDEX(axis)], slot);
        if (parked) {
            step_engines[CONFIG_INDEX(axis)].state = STEP_ENGINE_PARKED;
        } else if (settled) {
            resume_axis(axis);
        }
    }
    return settled;
}

// Read and clear the compare B flag. The match that makes a STEP edge sets it, and no other code
// uses it.
#define PULSED_CASE(number, timer)                                                       \
    case (number):                                                                       \
        pulsed = (TIFR##timer & _BV(OCF##timer##B)) != 0;                                \
        TIFR##timer = (uint8_t)_BV(OCF##timer##B);                                       \
        break;
bool step_timer_pulsed(uint8_t axis)
{
    bool pulsed = false;

    switch (CONFIG_INDEX(axis)) {
#define BOARD_AXIS(axis, timer) PULSED_CASE(axis, timer)
#include BOARD_FILE
    default:
        break;
    }
    return pulsed;
}

// The pin stays with the timer. A pin that is taken from the timer while it is high would rise once
// more when the timer gets it back.
#define SILENCE_CASE(number, timer)                                                      \
    case (number):                                                                       \
        ATOMIC_BLOCK(ATOMIC_FORCEON)                                                     \
        {                                                                                \
            OCR##timer##B = QUIET_TICKS;                                                 \
        }                                                                                \
        break;
void step_timer_silence(uint8_t axis)
{
    switch (CONFIG_INDEX(axis)) {
#define BOARD_AXIS(axis, timer) SILENCE_CASE(axis, timer)
#include BOARD_FILE
    default:
        break;
    }
    step_timer_halt(axis);
}

bool step_timer_underrun(void)
{
    return late_axes != 0;
}

bool step_timer_take_underrun(uint8_t axis)
{
    uint8_t bit = CONFIG_AXES == 1 ? 1u : (uint8_t)(1u << axis);
    bool late = (late_axes & bit) != 0;

    if (late) {
        ATOMIC_BLOCK(ATOMIC_RESTORESTATE)
        {
            late_axes &= (uint8_t)~bit;
        }
    }
    return late;
}

void step_timer_enable(uint8_t axis, bool on)
{
    pins_write_enable(axis, on);
}
