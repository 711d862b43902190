// SPDX-License-Identifier: MIT
#include "hal/pixel_clock.h"

#include <util/atomic.h>

#include "base/apart.h" // APART
#include "config.h"     // CONFIG_*, BOARD_PIXEL_CLOCK_TIMER
#include "hal/avr/capture.h"

static struct capture_queue edges;

#define PIXEL_CLOCK_HANDLER(timer)                                                       \
    CAPTURE_QUEUE_HANDLER(edges,                                                         \
                          timer,                                                         \
                          CONFIG_PIXEL_CLOCK_AXIS,                                       \
                          CAPTURE_PIXEL_CLOCK_BUSY,                                      \
                          CAPTURE_PIXEL_CLOCK_OVERRUN)
PIXEL_CLOCK_HANDLER(BOARD_PIXEL_CLOCK_TIMER)

#if CONFIG_AXES > 1
uint16_t capture_units_now(void)
{
    struct clock_look look;

    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        look = clock_look();
    }
    return (uint16_t)clock_look_units(&look);
}

// The edge of a parked axis has a period of its own, whatever has begun since.
static void place_parked(const struct capture_entry *entry, struct pixel_capture *capture)
{
    if ((entry->notes & CAPTURE_WAS_PARKED) != 0) {
        capture->back = 1;
        capture->sample.idle_count = step_isr_idle_count_at(
            CONFIG_PIXEL_CLOCK_AXIS, entry->idle_count, entry->captured);
    }
}
#else
static void place_parked(const struct capture_entry *entry, struct pixel_capture *capture)
{
    (void)entry;
    (void)capture;
}
#endif

APART bool pixel_clock_waiting(void)
{
    return edges.head != edges.tail;
}

bool pixel_clock_take(struct pixel_capture *capture)
{
    uint8_t tail = edges.tail;

    if (tail == edges.head) {
        return false;
    }
    const struct capture_entry *entry = &edges.entries[tail & (CONFIG_CLOCK_EDGES - 1u)];
    bool cut = (entry->notes & CAPTURE_CUT) != 0;

    capture->ticks = entry->captured;
    capture->back = entry->notes & CAPTURE_BACK;
    capture->sample = (struct engine_sample){
        .tail = entry->tail,
        .left = step_engine_size(entry->left_or_cut),
        .cut = cut,
        .train = !cut && entry->left_or_cut < 0,
        .idle_count = entry->idle_count,
    };
    place_parked(entry, capture);
    edges.tail = (uint8_t)(tail + 1u);
    return true;
}

bool pixel_clock_drop(void)
{
    bool any = pixel_clock_waiting();

    edges.tail = edges.head;
    edges.lost = 0;
    GPIOR0 &= (uint8_t)~_BV(CAPTURE_PIXEL_CLOCK_OVERRUN);
    return any;
}

uint8_t pixel_clock_take_lost(void)
{
    uint8_t lost = 0;

    if (edges.lost != 0) {
        ATOMIC_BLOCK(ATOMIC_FORCEON)
        {
            lost = edges.lost;
            edges.lost = 0;
        }
    }
    return lost;
}

bool pixel_clock_take_crowded(void)
{
    bool crowded = (GPIOR0 & _BV(CAPTURE_PIXEL_CLOCK_OVERRUN)) != 0;

    GPIOR0 &= (uint8_t)~_BV(CAPTURE_PIXEL_CLOCK_OVERRUN);
    return crowded;
}
