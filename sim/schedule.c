// SPDX-License-Identifier: MIT

#include "schedule.h"

#include <string.h>

#include "peripheral.h"

void schedule_attach(struct schedule *s,
                     avr_t *avr,
                     const struct own_time *time,
                     struct inputs *inputs,
                     struct supply *supply)
{
    s->avr = avr;
    s->time = time;
    s->inputs = inputs;
    s->supply = supply;
}

bool schedule_add(struct schedule *s, const struct scheduled_event *event)
{
    uint64_t cycle = own_time_from_bench(s->time, event->cycle);
    unsigned at = s->count;

    if (s->count == SCHEDULE_EVENTS) {
        return false;
    }
    while (at > 0 && s->event[at - 1].cycle > cycle) {
        s->event[at] = s->event[at - 1];
        at--;
    }
    s->event[at] = *event;
    // It may be passed within an instruction.
    s->event[at].cycle = (cycle < s->avr->cycle) ? s->avr->cycle : cycle;
    s->count++;
    schedule_restart(s);
    return true;
}

static void remove_first(struct schedule *s)
{
    s->count--;
    memmove(&s->event[0], &s->event[1], s->count * sizeof s->event[0]);
}

static avr_cycle_count_t on_event(avr_t *avr, avr_cycle_count_t when, void *param)
{
    struct schedule *s = param;

    (void)when;
    while (s->count > 0 && s->event[0].cycle <= avr->cycle) {
        struct scheduled_event event = s->event[0];

        remove_first(s);
        if (event.request == SUPPLY_REQUEST_NONE) {
            inputs_drive(s->inputs, event.port, event.bit, event.level, event.cycle);
        } else if (supply_has_effect(s->supply, event.request)) {
            supply_ask(s->supply, event.request);
            return 0; // the reset schedules the other events again
        }
    }
    return (s->count > 0) ? s->event[0].cycle : 0;
}

void schedule_restart(struct schedule *s)
{
    if (s->count > 0) {
        peripheral_schedule(s->avr, s->event[0].cycle, on_event, s);
    }
}
