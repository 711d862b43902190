// SPDX-License-Identifier: MIT

#include "run_loop.h"

#include <sim_core.h>

#include "peripheral.h"

#define STATE_AFTER_SEI  (-2) // simavr's interrupt_state right after the I bit was set
#define STATE_ONE_PASSED (-1)

// Cycles that simavr may run without coming back: each instruction comes back, so that no CLI goes
// unseen. Measured: a fifth slower than running freely from event to event.
#define RUN_LIMIT 1U

static avr_cycle_count_t on_end(avr_t *avr, avr_cycle_count_t when, void *param)
{
    (void)avr;
    (void)when;
    (void)param;
    return 0; // the event only had to end a sleep or a jump to itself
}

// Registered events are in order; the end of the present run is always among them.
static bool event_is_due(const avr_t *avr)
{
    return avr->cycle_timers.timer != NULL && avr->cycle_timers.timer->when <= avr->cycle;
}

// True when an interrupt may be served after the instruction that has just ended. "When the AVR
// exits from an interrupt, it will always return to the main program and execute one more
// instruction": simavr does so only where RETI sets I, not behind a handler that had set it.
static bool may_serve(struct irq_stats *stats, avr_t *avr)
{
    bool returned = stats->returned;

    stats->returned = false;
    if (avr->interrupt_state == STATE_AFTER_SEI) {
        avr->interrupt_state = STATE_ONE_PASSED;
        return false;
    }
    if (avr->interrupt_state == STATE_ONE_PASSED) {
        avr->interrupt_state = avr_has_pending_interrupts(avr) ? 1 : 0;
    }
    return !returned && avr->interrupt_state > 0 && avr->sreg[S_I] != 0;
}

static void serve(struct run_loop *loop)
{
    avr_t *avr = loop->avr;

    // Entries whose flag has been cleared since are passed over until one is served.
    do {
        avr_service_interrupts(avr);
    } while (avr->interrupt_state > 0 && avr->sreg[S_I] != 0);
    if (avr->sreg[S_I] == 0) {
        if (event_is_due(avr)) { // it fell into the cycles of the response
            (void)avr_cycle_timer_process(avr);
        }
        loop->hooks->served(loop->hooks->board);
    }
}

// To the very cycle of the next event.
static void sleep_on(struct run_loop *loop)
{
    avr_t *avr = loop->avr;
    avr_cycle_count_t idle_cycles;

    if (avr->sreg[S_I] == 0) {
        avr->state = cpu_Done; // nothing can wake it: the program's way to end
        return;
    }
    idle_cycles = avr_cycle_timer_process(avr);
    if (avr->state != cpu_Sleeping) {
        return; // woken by what was due just now
    }
    avr->cycle += idle_cycles;
    loop->sleep_cycles += idle_cycles;
    loop->stats->woken = true;
}

static void serve_if_due(struct run_loop *loop, avr_t *avr)
{
    if (avr->state == cpu_Running && may_serve(loop->stats, avr)) {
        serve(loop);
    }
    irq_stats_interrupts_off(loop->stats, avr->sreg[S_I] == 0);
}

// True while nothing can come between two instructions but an event: no interrupt waits that the
// program lets in, and none will be let in by what has just been executed.
static bool is_undisturbed(const avr_t *avr)
{
    return avr->interrupt_state == 0 || (avr->interrupt_state > 0 && avr->sreg[S_I] == 0);
}

// Plain instructions up to the next event, or up to one for simavr and that one too. Returns the
// program counter of the next instruction.
static inline avr_flashaddr_t execute_up_to_event(const struct run_loop *loop, avr_t *avr)
{
    const avr_cycle_timer_slot_t *event = avr->cycle_timers.timer;

    if (is_undisturbed(avr) &&
        plain_run(loop->image.program, avr, (event != NULL) ? event->when : loop->end)) {
        return avr->pc;
    }
    return skips_mend(loop->image.skips, avr, avr_run_one(avr));
}

// Instructions up to the next event or interrupt, the events due by then, and an interrupt if one
// may be served.
static inline void execute(struct run_loop *loop, avr_t *avr)
{
    avr_flashaddr_t next_pc = avr->pc;

    if (avr->state == cpu_Running) {
        loop->stats->woken = false;
        next_pc = execute_up_to_event(loop, avr);
    }
    if (event_is_due(avr)) {
        (void)avr_cycle_timer_process(avr);
    }
    avr->pc = next_pc;
    if (avr->state == cpu_Sleeping) {
        sleep_on(loop);
    }
    serve_if_due(loop, avr);
}

// ---- in the place of the program ----

#define TO_ITSELF_CYCLES 2U // rjmp .-2

// Jumps once, or with `repeat` until the next event is due (the end of the run is always one).
static void jump_to_itself(avr_t *avr, bool repeat)
{
    uint64_t cycles = TO_ITSELF_CYCLES;

    if (repeat && avr->cycle_timers.timer != NULL &&
        avr->cycle_timers.timer->when > avr->cycle) {
        cycles = avr->cycle_timers.timer->when - avr->cycle + TO_ITSELF_CYCLES - 1;
        cycles -= cycles % TO_ITSELF_CYCLES;
    }
    avr->cycle += cycles;
    if (event_is_due(avr)) {
        (void)avr_cycle_timer_process(avr);
    }
}

static void execute_handlers(struct run_loop *loop)
{
    avr_t *avr = loop->avr;

    if (avr->state != cpu_Running || loop->stats->depth > 0 || avr->sreg[S_I] == 0) {
        execute(loop, avr);
        return;
    }
    jump_to_itself(avr, avr->interrupt_state == 0);
    serve_if_due(loop, avr);
}

static void execute_nothing(struct run_loop *loop)
{
    avr_t *avr = loop->avr;

    avr->state = cpu_Running;
    avr->sreg[S_I] = 0;
    avr->interrupt_state = 0;
    irq_stats_interrupts_off(loop->stats, true);
    jump_to_itself(avr, true);
}

static void pass_unpowered(struct run_loop *loop)
{
    avr_t *avr = loop->avr;

    if (avr->cycle_timers.timer != NULL && avr->cycle_timers.timer->when > avr->cycle) {
        avr->cycle = avr->cycle_timers.timer->when;
    }
    (void)avr_cycle_timer_process(avr);
}

static void execute_in_state(struct run_loop *loop)
{
    switch (loop->state) {
    case RUN_MAIN_HUNG:
        execute_handlers(loop);
        break;
    case RUN_ALL_HUNG:
        execute_nothing(loop);
        break;
    case RUN_UNPOWERED:
        pass_unpowered(loop);
        break;
    case RUN_REQUESTED:
        loop->hooks->requested(loop->hooks->board);
        break;
    case RUN_PROGRAM:
    default:
        execute(loop, loop->avr);
        break;
    }
}

// ---- the loop ----

void run_loop_attach(struct run_loop *loop,
                     avr_t *avr,
                     struct irq_stats *stats,
                     const struct run_loop_image *image,
                     const struct run_loop_hooks *hooks)
{
    loop->avr = avr;
    loop->stats = stats;
    loop->image = *image;
    loop->hooks = hooks;
    loop->state = RUN_PROGRAM;
}

void run_loop_request(struct run_loop *loop)
{
    avr_t *avr = loop->avr;

    loop->state = RUN_REQUESTED;
    if (avr->state == cpu_Sleeping) {
        avr->state = cpu_Running;
    }
    avr->interrupt_state = 0; // no interrupt is served any more
}

void run_loop_schedule(struct run_loop *loop)
{
    if (loop->avr->cycle < loop->end) {
        peripheral_schedule(loop->avr, loop->end, on_end, loop);
    }
}

static bool can_go_on(const avr_t *avr)
{
    return avr->state == cpu_Running || avr->state == cpu_Sleeping;
}

// Not inside a handler that keeps interrupts off: nothing can hold up its instructions.
void run_loop_stall(struct run_loop *loop, uint64_t cycles)
{
    avr_t *avr = loop->avr;
    avr_cycle_count_t end;

    while (can_go_on(avr) && loop->state == RUN_PROGRAM && avr->sreg[S_I] == 0) {
        execute(loop, avr);
    }
    end = avr->cycle + cycles;
    while (avr->cycle < end) {
        const avr_cycle_timer_slot_t *event = avr->cycle_timers.timer;

        avr->cycle = (event != NULL && event->when < end) ? event->when : end;
        if (event_is_due(avr)) {
            (void)avr_cycle_timer_process(avr);
        }
    }
}

bool run_loop_run(struct run_loop *loop, uint64_t cycle)
{
    avr_t *avr = loop->avr;

    avr->run_cycle_limit = avr->run_cycle_count = RUN_LIMIT;
    loop->end = cycle;
    run_loop_schedule(loop);
    while (can_go_on(avr) && avr->cycle < cycle) {
        if (loop->state == RUN_PROGRAM) {
            execute(loop, avr);
        } else {
            execute_in_state(loop);
        }
    }
    return can_go_on(avr);
}
