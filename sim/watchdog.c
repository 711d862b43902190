// SPDX-License-Identifier: MIT

#include "watchdog.h"

#include <string.h>

#include <sim_regbit.h>

#include "access.h"

// Bits of WDTCSR.
#define WDIF    0x80U
#define WDIE    0x40U
#define WDP3    0x20U
#define WDCE    0x10U
#define WDE     0x08U
#define WDP2_0  0x07U
#define WDP     (WDP3 | WDP2_0)
#define WDP_TOP 9U

static uint8_t *control_register(const struct watchdog *w)
{
    return &w->avr->data[w->part->wdce.reg];
}

static bool is_running(const struct watchdog *w)
{
    return (*control_register(w) & (WDE | WDIE)) != 0;
}

static unsigned prescaler_bits(const struct watchdog *w)
{
    return (*control_register(w) & WDP2_0) |
           (unsigned)((*control_register(w) & WDP3) >> 2);
}

static uint64_t time_out_cycle(const struct watchdog *w)
{
    return w->since +
           (peripheral_cycles_of_us(w->avr, WATCHDOG_SHORTEST_US) << prescaler_bits(w));
}

static void time_out(struct watchdog *w)
{
    uint8_t bits = *control_register(w);
    bool waited = (bits & WDE) != 0 && (bits & WDIF) != 0;

    if ((bits & WDIE) == 0 || waited) {
        w->hooks->reset(w->hooks->host.board);
        return;
    }
    peripheral_raise(&w->hooks->host, w->avr, &w->part->watchdog, time_out_cycle(w));
}

// WDR only moves the time-out; the event finds this out when it comes, so that WDR costs nothing.
static avr_cycle_count_t on_time_out_due(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct watchdog *w = param;

    (void)when;
    if (!is_running(w)) {
        return 0;
    }
    if (time_out_cycle(w) <= avr->cycle) {
        uint64_t at = time_out_cycle(w);

        time_out(w);
        w->since = at;
    }
    return time_out_cycle(w);
}

static void schedule_time_out(struct watchdog *w)
{
    if (!is_running(w)) {
        avr_cycle_timer_cancel(w->avr, on_time_out_due, w);
    } else {
        peripheral_schedule(w->avr, time_out_cycle(w), on_time_out_due, w);
    }
}

void watchdog_restart(struct watchdog *w)
{
    w->since = w->avr->cycle + 1;
}

static bool reset_flag_set(const struct watchdog *w)
{
    return avr_regbit_get(w->avr, w->part->wdrf) != 0;
}

// WDIF, WDIE, WDE and WDP after a write of `value`.
static uint8_t control_after_write(const struct watchdog *w,
                                   uint8_t value,
                                   bool may_change)
{
    uint8_t before = *control_register(w);
    uint8_t locked = (uint8_t)(WDP | (before & WDE)); // WDE can always be set
    uint8_t after = value & (WDIE | WDE | WDP);

    if (!may_change) {
        after = (uint8_t)((after & ~locked) | (before & locked));
    }
    after |= before & (uint8_t)~value & WDIF; // write one to clear
    return reset_flag_set(w) ? (after | WDE) : after;
}

static void follow_interrupt(struct watchdog *w, uint64_t cycle)
{
    avr_int_vector_t *vector = &w->part->watchdog;
    bool wanted = (*control_register(w) & (WDIF | WDIE)) == (WDIF | WDIE);

    if (!wanted) {
        vector->pending = 0;
    } else if (!vector->pending) {
        peripheral_raise(&w->hooks->host, w->avr, vector, cycle);
    }
}

static void write_control(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct watchdog *w = param;
    uint64_t cycle = access_cycle(avr);
    bool opening = (value & (WDCE | WDE)) == (WDCE | WDE);
    bool may_change = cycle <= w->change_until && (value & WDCE) == 0;
    bool ran = is_running(w);

    avr->data[address] = control_after_write(w, value, may_change);
    w->change_until = opening ? cycle + WATCHDOG_CHANGE_TICKS : 0;
    if (!ran) {
        w->since = cycle + 1;
    }
    if (prescaler_bits(w) > WDP_TOP) {
        peripheral_refuse(
            &w->hooks->host, "watchdog: WDP3:0 = %u is reserved", prescaler_bits(w));
        return;
    }
    follow_interrupt(w, cycle + 1);
    schedule_time_out(w);
}

// simavr stores the value returned in the register.
static uint8_t read_control(avr_t *avr, avr_io_addr_t address, void *param)
{
    const struct watchdog *w = param;

    return (uint8_t)((avr->data[address] & ~WDCE) |
                     (access_cycle(avr) <= w->change_until ? WDCE : 0U));
}

// "Executing the corresponding interrupt vector will clear WDIE and WDIF" (WDIF: simavr does).
static void on_running(struct avr_irq_t *irq, uint32_t value, void *param)
{
    const struct watchdog *w = param;

    (void)irq;
    if (value != 0 && (*control_register(w) & WDE) != 0) {
        *control_register(w) &= (uint8_t)~WDIE;
    }
}

void watchdog_reset(struct watchdog *w)
{
    *control_register(w) = reset_flag_set(w) ? WDE : 0;
    w->since = w->avr->cycle;
    w->change_until = 0;
    schedule_time_out(w);
}

void watchdog_attach(struct watchdog *w, avr_t *avr, const struct watchdog_hooks *hooks)
{
    avr_watchdog_t *part = peripheral_find(avr, "watchdog", "watchdog");

    memset(w, 0, sizeof *w);
    w->avr = avr;
    w->part = part;
    w->hooks = hooks;
    part->io.reset = NULL; // it would start its own timer
    part->io.ioctl = NULL; // the board passes WDR on
    access_take(avr, part->wdce.reg, read_control, write_control, w);
    avr_irq_register_notify(&part->watchdog.irq[AVR_INT_IRQ_RUNNING], on_running, w);
}
