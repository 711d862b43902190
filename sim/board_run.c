// SPDX-License-Identifier: MIT

#include "board_run.h"

#include <stdio.h>

#include <sim_core.h>

#include "board.h"

#define STATE_AFTER_SEI  (-2) // simavr's interrupt_state right after the I bit was set
#define STATE_ONE_PASSED (-1)

// Cycles that simavr may run without coming back: each instruction comes back, so that no CLI goes
// unseen. Measured: a fifth slower than running freely from event to event.
#define RUN_LIMIT 1U

static avr_cycle_count_t on_quantum_end(avr_t *avr, avr_cycle_count_t when, void *param)
{
    (void)avr;
    (void)when;
    (void)param;
    return 0; // it only had to end the stretch of instructions
}

// Registered events are in order; the quantum's end is always among them.
static bool event_is_due(const avr_t *avr)
{
    return avr->cycle_timers.timer != NULL && avr->cycle_timers.timer->when <= avr->cycle;
}

// True when an interrupt may be served after the instruction that has just ended. "When the AVR
// exits from an interrupt, it will always return to the main program and execute one more
// instruction": simavr does so only where RETI sets I, not behind a handler that had set it.
static bool may_serve(struct board *b)
{
    avr_t *avr = b->avr;
    bool returned = b->stats.returned;

    b->stats.returned = false;
    if (avr->interrupt_state == STATE_AFTER_SEI) {
        avr->interrupt_state = STATE_ONE_PASSED;
        return false;
    }
    if (avr->interrupt_state == STATE_ONE_PASSED) {
        avr->interrupt_state = avr_has_pending_interrupts(avr) ? 1 : 0;
    }
    return !returned && avr->interrupt_state > 0 && avr->sreg[S_I] != 0;
}

static void serve(struct board *b)
{
    avr_t *avr = b->avr;

    // Entries whose flag has been cleared since are passed over until one is served.
    do {
        avr_service_interrupts(avr);
    } while (avr->interrupt_state > 0 && avr->sreg[S_I] != 0);
    if (avr->sreg[S_I] == 0) {
        if (event_is_due(avr)) { // it fell into the cycles of the response
            (void)avr_cycle_timer_process(avr);
        }
        uart_levels(&b->uart);
        eeprom_levels(&b->eeprom);
    }
}

// To the very cycle of the next event.
static void sleep_on(struct board *b)
{
    avr_t *avr = b->avr;
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
    b->sleep_cycles += idle_cycles;
    b->stats.woken = true;
}

// One instruction, the events due by its end, and an interrupt if one may be served.
static inline void slice(struct board *b, avr_t *avr)
{
    avr_flashaddr_t next_pc = avr->pc;

    if (avr->state == cpu_Running) {
        b->stats.woken = false;
        next_pc = skips_mend(&b->skips, avr, avr_run_one(avr));
    }
    if (event_is_due(avr)) {
        (void)avr_cycle_timer_process(avr);
    }
    avr->pc = next_pc;
    if (avr->state == cpu_Sleeping) {
        sleep_on(b);
    }
    if (avr->state == cpu_Running && may_serve(b)) {
        serve(b);
    }
    irq_stats_interrupts_off(&b->stats, avr->sreg[S_I] == 0);
}

void board_slice(avr_t *avr)
{
    slice(avr->custom.data, avr);
}

// ---- in the place of the program ----

#define TO_ITSELF_CYCLES 2U // rjmp .-2

// At least once; `often`: until the next event is due (the quantum's end is always among them).
static void jump_to_itself(avr_t *avr, bool often)
{
    uint64_t cycles = TO_ITSELF_CYCLES;

    if (often && avr->cycle_timers.timer != NULL &&
        avr->cycle_timers.timer->when > avr->cycle) {
        cycles = avr->cycle_timers.timer->when - avr->cycle + TO_ITSELF_CYCLES - 1;
        cycles -= cycles % TO_ITSELF_CYCLES;
    }
    avr->cycle += cycles;
    if (event_is_due(avr)) {
        (void)avr_cycle_timer_process(avr);
    }
}

// The main program has reached an instruction that jumps to itself; interrupts are served.
static void hang_main(avr_t *avr)
{
    struct board *b = avr->custom.data;

    if (avr->state != cpu_Running || b->stats.depth > 0 || avr->sreg[S_I] == 0) {
        slice(b, avr);
        return;
    }
    jump_to_itself(avr, avr->interrupt_state == 0);
    if (avr->state == cpu_Running && may_serve(b)) {
        serve(b);
    }
    irq_stats_interrupts_off(&b->stats, avr->sreg[S_I] == 0);
}

static void hang_all(avr_t *avr)
{
    struct board *b = avr->custom.data;

    avr->state = cpu_Running;
    avr->sreg[S_I] = 0;
    avr->interrupt_state = 0;
    irq_stats_interrupts_off(&b->stats, true);
    jump_to_itself(avr, true);
}

// Nothing runs; what happens outside does.
static void stand_dark(avr_t *avr)
{
    if (avr->cycle_timers.timer != NULL && avr->cycle_timers.timer->when > avr->cycle) {
        avr->cycle = avr->cycle_timers.timer->when;
    }
    (void)avr_cycle_timer_process(avr);
}

static bool alive(const struct board *b)
{
    return b->avr->state == cpu_Running || b->avr->state == cpu_Sleeping;
}

bool board_is_done(const struct board *b)
{
    return b->avr->state == cpu_Done;
}

avr_run_t board_next_run(const struct board *b)
{
    if (b->want != BOARD_WANT_NONE) {
        return board_do_wanted;
    }
    if (!b->powered) {
        return stand_dark;
    }
    if (b->hang.all) {
        return hang_all;
    }
    return b->hang.main ? hang_main : board_slice;
}

void board_schedule_end(struct board *b)
{
    uint64_t now = b->avr->cycle;

    if (now < b->quantum_end) {
        avr_cycle_timer_register(b->avr, b->quantum_end - now, on_quantum_end, b);
    }
}

bool board_run(struct board *b, uint64_t cycle)
{
    avr_t *avr = b->avr;

    avr->run_cycle_limit = avr->run_cycle_count = RUN_LIMIT;
    b->quantum_end = cycle;
    board_schedule_end(b);
    while (alive(b) && avr->cycle < cycle) {
        if (avr->run == board_slice) {
            slice(b, avr);
        } else { // a reset, a hang or no power
            avr->run(avr);
        }
    }
    if (avr->state == cpu_Crashed && b->error[0] == '\0') {
        board_refuse(b, "the program crashed (invalid instruction or address)");
    }
    return alive(b);
}
