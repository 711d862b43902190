// SPDX-License-Identifier: MIT

#include "supply.h"

#include "access.h"

#define MCUSR     0x54U // data address, the same on all parts
#define REGISTERS 32U   // r0 to r31, the first data addresses

// Write zero to clear.
static void write_mcusr(avr_t *avr, avr_io_addr_t address, uint8_t value, void *param)
{
    (void)param;
    avr->data[address] &= value;
}

void supply_attach(struct supply *s,
                   avr_t *avr,
                   struct stack_watch *stack,
                   const struct supply_hooks *hooks)
{
    s->avr = avr;
    s->stack = stack;
    s->hooks = hooks;
    s->powered = true;
    s->mcusr = 1U << SUPPLY_POWER_ON;
    access_take(avr, MCUSR, NULL, write_mcusr, s);
}

void supply_reset(struct supply *s)
{
    s->avr->data[MCUSR] = s->mcusr;
}

static void fill_with_noise(struct supply *s)
{
    avr_t *avr = s->avr;
    unsigned first = avr->ioend + 1U;

    stack_before_noise(s->stack, avr);
    noise_fill(&s->noise, avr->data, REGISTERS);
    noise_fill(&s->noise, &avr->data[first], avr->ramend + 1U - first);
    stack_after_noise(s->stack, avr);
}

static void restart(struct supply *s, bool cold)
{
    s->request = SUPPLY_REQUEST_NONE;
    s->hooks->restart(s->hooks->board, cold);
}

static void power_off(struct supply *s)
{
    s->hooks->power_failed(s->hooks->board);
    s->mcusr = 0;
    s->powered = false;
    restart(s, true);
}

static void power_on(struct supply *s)
{
    s->powered = true;
    s->mcusr = 1U << SUPPLY_POWER_ON;
    fill_with_noise(s);
    restart(s, true);
}

static void reset(struct supply *s, enum supply_cause cause)
{
    s->mcusr = (uint8_t)(s->avr->data[MCUSR] | 1U << cause);
    restart(s, false);
}

void supply_do(struct supply *s, enum supply_request request)
{
    switch (request) {
    case SUPPLY_REQUEST_OFF:
        power_off(s);
        break;
    case SUPPLY_REQUEST_ON:
        power_on(s);
        break;
    case SUPPLY_REQUEST_CYCLE:
        power_off(s);
        power_on(s);
        break;
    case SUPPLY_REQUEST_WATCHDOG:
        reset(s, SUPPLY_WATCHDOG);
        break;
    case SUPPLY_REQUEST_BROWN_OUT:
        reset(s, SUPPLY_BROWN_OUT);
        break;
    case SUPPLY_REQUEST_EXTERNAL:
        reset(s, SUPPLY_EXTERNAL);
        break;
    case SUPPLY_REQUEST_NONE:
    default:
        break;
    }
}

bool supply_has_effect(const struct supply *s, enum supply_request request)
{
    return (request == SUPPLY_REQUEST_ON) ? !s->powered : s->powered;
}

void supply_ask(struct supply *s, enum supply_request request)
{
    if (request > s->request) {
        s->request = request;
    }
    s->hooks->requested(s->hooks->board);
}

void supply_fulfil(struct supply *s)
{
    enum supply_request request = s->request;

    s->request = SUPPLY_REQUEST_NONE;
    supply_do(s, request);
}
