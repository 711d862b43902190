// SPDX-License-Identifier: MIT
#include "hal/pixel_clock.h"

#include <util/atomic.h>

#include "avr/hal/capture_queue.h"
#include "avr/hal/flag_bits.h"   // FLAG_*
#include "avr/hal/step_isr.h"    // step_engines
#include "avr/hal/step_parked.h" // step_parked_idle_count_at
#include "base/apart.h"          // APART_SMALL, BY_POINTER
#include "config.h"              // CONFIG_*

struct capture_queue pixel_clock_edges;

#if CONFIG_AXES > 1
// The edge of a parked axis has a period of its own, whatever has begun since.
static inline void place_idle(const struct captured_edge *entry,
                              struct pixel_capture *capture)
{
    capture->sample.idle_count = entry->idle_count;
    if ((entry->notes & CAPTURED_EDGE_WAS_PARKED) != 0) {
        capture->back = 1;
        capture->sample.idle_count = step_parked_idle_count_at(
            CONFIG_PIXEL_CLOCK_AXIS, entry->idle_count, entry->ticks);
    }
}
#else
// The engine has counted less than 256 periods since.
static inline void place_idle(const struct captured_edge *entry,
                              struct pixel_capture *capture)
{
    uint16_t now = 0;

    ATOMIC_BLOCK(ATOMIC_FORCEON)
    {
        now = step_engines[CONFIG_PIXEL_CLOCK_AXIS].idle_count;
    }
    capture->sample.idle_count = (uint16_t)(now - (uint8_t)(now - entry->idle_count));
}
#endif

APART_SMALL bool pixel_clock_waiting(void)
{
    return pixel_clock_edges.head != pixel_clock_edges.tail;
}

bool pixel_clock_take(struct pixel_capture *capture)
{
    uint8_t tail = pixel_clock_edges.tail;

    if (tail == pixel_clock_edges.head) {
        return false;
    }
    const struct captured_edge *entry =
        &pixel_clock_edges.entries[tail & (CONFIG_CLOCK_EDGES - 1u)];
    BY_POINTER(entry);
    uint8_t notes = entry->notes;
    int8_t left_or_cut = entry->left_or_cut;
    bool cut = (notes & CAPTURED_EDGE_CUT) != 0;

    capture->ticks = entry->ticks;
    capture->back = notes & CAPTURED_EDGE_BACK;
    capture->sample.tail = entry->tail;
    capture->sample.left = step_engine_size(left_or_cut);
    capture->sample.cut = cut;
    capture->sample.train = !cut && left_or_cut < 0;
    place_idle(entry, capture);
    pixel_clock_edges.tail = (uint8_t)(tail + 1u);
    return true;
}

bool pixel_clock_drop(void)
{
    bool any = pixel_clock_waiting();

    pixel_clock_edges.tail = pixel_clock_edges.head;
    pixel_clock_edges.lost = 0;
    GPIOR0 &= (uint8_t)~_BV(FLAG_PIXEL_CLOCK_OVERRUN);
    return any;
}

bool pixel_clock_any_lost(void)
{
    return pixel_clock_edges.lost != 0 || (GPIOR0 & _BV(FLAG_PIXEL_CLOCK_OVERRUN)) != 0;
}

uint8_t pixel_clock_take_lost(void)
{
    uint8_t lost = 0;

    if (pixel_clock_edges.lost != 0) {
        ATOMIC_BLOCK(ATOMIC_FORCEON)
        {
            lost = pixel_clock_edges.lost;
            pixel_clock_edges.lost = 0;
        }
    }
    return lost;
}

bool pixel_clock_take_crowded(void)
{
    bool crowded = (GPIOR0 & _BV(FLAG_PIXEL_CLOCK_OVERRUN)) != 0;

    GPIOR0 &= (uint8_t)~_BV(FLAG_PIXEL_CLOCK_OVERRUN);
    return crowded;
}
