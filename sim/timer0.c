// SPDX-License-Identifier: MIT

#include "timer0.h"

#include <string.h>

#include <sim_regbit.h>

#include "access.h"

#define TCCR0A      0x44U // data addresses, the same on all parts
#define TCCR0B      0x45U
#define OCR0B       0x48U
#define TIMSK0      0x6EU
#define CHANNEL_B   1
#define COM0B_BITS  0x30U
#define COM0B_SHIFT 4
#define MODE_BITS_A 0x03U
#define CS_BITS     0x07U
#define CS_BY_64    3U
#define FORCE_BITS  0xC8U // FOC0A, FOC0B, WGM02 in TCCR0B
#define TICK        UINT64_C(64)
#define WRAP        (256U * TICK)

enum { COM_PORT = 0, COM_TOGGLE = 1, COM_CLEAR = 2, COM_SET = 3 };

static unsigned com_of(const struct timer0 *t)
{
    return (t->avr->data[TCCR0A] & COM0B_BITS) >> COM0B_SHIFT;
}

bool timer0_is_connected(const struct timer0 *t)
{
    return com_of(t) != COM_PORT;
}

static bool is_counting(const struct timer0 *t)
{
    return (t->avr->data[TCCR0B] & CS_BITS) != 0;
}

static void apply_match(struct timer0 *t)
{
    avr_int_vector_t *vector = &t->part->comp[CHANNEL_B].interrupt;
    bool before = t->oc_level;

    if (avr_regbit_get(t->avr, vector->raised) == 0) {
        peripheral_raise(&t->hooks->host, t->avr, vector, t->due);
    }
    if (com_of(t) == COM_TOGGLE) {
        t->oc_level = !t->oc_level;
    } else if (com_of(t) != COM_PORT) {
        t->oc_level = com_of(t) == COM_SET;
    }
    if (t->oc_level != before) {
        t->hooks->output(t->hooks->host.board, t->due);
    }
}

static avr_cycle_count_t on_match(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct timer0 *t = param;

    (void)when;
    while (t->due != 0 && t->due <= avr->cycle) {
        apply_match(t);
        t->due += WRAP;
    }
    return t->due;
}

// The first match after this cycle.
static void plan(struct timer0 *t, uint64_t cycle)
{
    if (!is_counting(t)) {
        t->due = 0;
        return;
    }
    t->due = t->part->tov_base + (t->ocr + 1U) * TICK;
    while (t->due <= cycle) {
        t->due += WRAP;
    }
    peripheral_schedule(t->avr, t->due, on_match, t);
}

static void refuse_unknown(struct timer0 *t)
{
    const uint8_t *data = t->avr->data;
    bool by_64 = (data[TCCR0B] & CS_BITS) == CS_BY_64;

    if (timer0_is_connected(t) &&
        ((data[TCCR0A] & MODE_BITS_A) != 0 || (data[TCCR0B] & FORCE_BITS) != 0 ||
         (is_counting(t) && !by_64))) {
        peripheral_refuse(&t->hooks->host,
                          "timer 0: compare B is modelled in mode 0 at clk/64 only");
    }
}

static void write_tccra(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer0 *t = param;

    avr->data[address] = value;
    refuse_unknown(t);
    t->hooks->output(t->hooks->host.board, access_cycle(avr) + 1);
}

static void write_tccrb(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer0 *t = param;

    t->start(avr, address, value, t->start_param);
    refuse_unknown(t);
    plan(t, access_cycle(avr));
}

static void write_ocr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer0 *t = param;

    avr->data[address] = value;
    t->ocr = value;
    plan(t, access_cycle(avr));
}

// simavr forgets an interrupt that is disabled while it waits; on the part its flag stays, and the
// interrupt comes once it is enabled again.
static void write_timsk(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    struct timer0 *t = param;
    avr_int_vector_t *vector = &t->part->comp[CHANNEL_B].interrupt;

    avr->data[address] = value;
    if (avr_regbit_get(avr, vector->enable) == 0) {
        vector->pending = 0;
    } else if (avr_regbit_get(avr, vector->raised) != 0 && !vector->pending) {
        peripheral_raise(&t->hooks->host, avr, vector, access_cycle(avr) + 1);
    }
}

void timer0_reset(struct timer0 *t)
{
    t->ocr = 0;
    t->due = 0;
    t->oc_level = false;
}

void timer0_attach(struct timer0 *t, avr_t *avr, const struct timer0_hooks *hooks)
{
    const avr_io_addr_t tccrb = AVR_DATA_TO_IO(TCCR0B);

    memset(t, 0, sizeof *t);
    t->avr = avr;
    t->hooks = hooks;
    for (avr_io_t *io = peripheral_next(avr->io_port, "timer"); io != NULL;
         io = peripheral_next(io->next, "timer")) {
        if (((avr_timer_t *)(void *)io)->name == '0') {
            t->part = (avr_timer_t *)(void *)io;
        }
    }
    if (t->part == NULL) {
        peripheral_missing("timer 0");
    }
    t->part->comp[CHANNEL_B].r_ocr =
        0; // libsimavr passes over a channel without a register
    t->start = avr->io[tccrb].w.c;
    t->start_param = avr->io[tccrb].w.param;
    access_take(avr, TCCR0A, NULL, write_tccra, t);
    access_take(avr, TCCR0B, avr->io[tccrb].r.c, write_tccrb, t);
    access_take(avr, OCR0B, NULL, write_ocr, t);
    access_take(avr, TIMSK0, NULL, write_timsk, t);
}
