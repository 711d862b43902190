// SPDX-License-Identifier: MIT

#include "pixel_input.h"

#include "peripheral.h"

static uint64_t next_edge(const struct pixel_input *p)
{
    const struct pixel_pulse *pulse = &p->pulse[p->first % PIXEL_INPUT_PULSES];

    return p->high ? pulse->fall : pulse->rise;
}

void pixel_input_drive(const struct pixel_input *p, bool level, uint64_t cycle)
{
    inputs_drive(p->inputs, p->pin->port, p->pin->bit, level, cycle);
    if (p->copy != NULL) {
        inputs_drive(p->inputs, p->copy->port, p->copy->bit, level, cycle);
    }
}

static avr_cycle_count_t on_edge(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct pixel_input *p = param;

    (void)when;
    while (p->first != p->last) {
        uint64_t due = next_edge(p);

        if (due > avr->cycle) {
            return due;
        }
        p->high = !p->high;
        p->first += p->high ? 0 : 1;
        pixel_input_drive(p, p->high, due);
    }
    return 0;
}

void pixel_input_schedule(struct pixel_input *p)
{
    if (p->first != p->last) {
        peripheral_schedule(p->avr, next_edge(p), on_edge, p);
    }
}

bool pixel_input_add(struct pixel_input *p, const struct pixel_pulse *pulse)
{
    if (p->last - p->first >= PIXEL_INPUT_PULSES) {
        return false;
    }
    p->pulse[p->last++ % PIXEL_INPUT_PULSES] = *pulse;
    if (p->last - p->first == 1) {
        pixel_input_schedule(p);
    }
    return true;
}

void pixel_input_attach(struct pixel_input *p,
                        avr_t *avr,
                        const struct board_kind *kind,
                        struct inputs *inputs)
{
    p->avr = avr;
    p->inputs = inputs;
    p->pin = board_kind_pin(kind, SIGNAL_PIXEL_CLOCK, 0);
    p->copy = board_kind_pin(kind, SIGNAL_PIXEL_CLOCK_COPY, 0);
}
