// SPDX-License-Identifier: MIT
#include "app/axes/events.h"

#if FEATURE_EVENTS

#include "hal/clock.h" // clock_now_units

struct event {
    uint16_t code;
    uint8_t axis;
    uint16_t argument;
    uint32_t pixel;
    uint32_t time_ms; // time since reset; wraps after some hours (4.7 at 16 MHz)
};

static struct {
    struct event ring[CONFIG_EVENTS];
    uint16_t count; // events since reset; the ring keeps the newest CONFIG_EVENTS of them
} events;

void events_start(void)
{
    events.count = 0;
}

void events_note(uint16_t code, uint8_t axis, uint16_t argument, uint32_t pixel)
{
    events.ring[events.count % CONFIG_EVENTS] = (struct event){
        .code = code,
        .axis = axis,
        .argument = argument,
        .pixel = pixel,
        .time_ms = clock_ms_of_units(clock_now_units()),
    };
    events.count++;
}

static uint16_t event_word(const struct event *event, uint16_t number, uint8_t word)
{
    switch (word) {
    case 0:
        return number;
    case 1:
        return event->code;
    case 2:
        return event->axis;
    case 3:
        return event->argument;
    case 4:
        return (uint16_t)(event->pixel >> 16);
    case 5:
        return (uint16_t)event->pixel;
    case 6:
        return (uint16_t)(event->time_ms >> 16);
    default:
        return (uint16_t)event->time_ms;
    }
}

uint16_t events_word(uint16_t address)
{
    uint16_t offset = (uint16_t)(address - REG_EVENT_BASE);

    if (offset < REG_EVENT_HEADER) {
        return events.count;
    }
    offset = (uint16_t)(offset - REG_EVENT_HEADER);
    // The oldest event that is kept comes first.
    uint16_t kept = events.count < CONFIG_EVENTS ? events.count : CONFIG_EVENTS;
    uint16_t index = (uint16_t)(events.count - kept + offset / (uint16_t)REG_EVENT_WORDS);

    return index >= events.count ? 0
                                 : event_word(&events.ring[index % CONFIG_EVENTS],
                                              (uint16_t)(index + 1u),
                                              (uint8_t)(offset % REG_EVENT_WORDS));
}

#endif
