// SPDX-License-Identifier: MIT
#include "app/events.h"

#if FEATURE_EVENTS

#include <stddef.h> // NULL

#include "hal/clock.h"  // clock_now_units
#include "wire/bytes.h" // put_word

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

// The event that an offset behind the header belongs to: how many came before it since reset.
static uint16_t index_of(uint16_t offset)
{
    // The oldest event that is kept comes first.
    uint16_t kept = events.count < CONFIG_EVENTS ? events.count : CONFIG_EVENTS;

    return (uint16_t)(events.count - kept + offset / (uint16_t)REG_EVENT_WORDS);
}

// The event of that index; NULL: there is none.
static const struct event *event_at(uint16_t index)
{
    return index >= events.count ? NULL : &events.ring[index % CONFIG_EVENTS];
}

uint16_t events_word(uint16_t address)
{
    uint16_t offset = (uint16_t)(address - REG_EVENT_BASE);

    if (offset < REG_EVENT_HEADER) {
        return events.count;
    }
    offset = (uint16_t)(offset - REG_EVENT_HEADER);
    uint16_t index = index_of(offset);
    const struct event *event = event_at(index);

    return event == NULL ? 0
                         : event_word(event,
                                      (uint16_t)(index + 1u),
                                      (uint8_t)(offset % REG_EVENT_WORDS));
}

uint8_t events_words(uint16_t address, uint8_t count, uint8_t *to)
{
    uint16_t offset = (uint16_t)(address - REG_EVENT_BASE - REG_EVENT_HEADER);
    uint16_t index = index_of(offset);
    uint8_t whole = count / REG_EVENT_WORDS;

    if (offset % REG_EVENT_WORDS != 0) {
        return 0;
    }
    for (uint8_t i = 0; i < whole; i++) {
        const struct event *event = event_at(index++);
        for (uint8_t word = 0; word < REG_EVENT_WORDS; word++) {
            put_word(to, event == NULL ? 0 : event_word(event, index, word));
            to += 2;
        }
    }
    return (uint8_t)(whole * REG_EVENT_WORDS);
}

#endif
