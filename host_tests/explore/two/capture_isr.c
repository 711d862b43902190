// SPDX-License-Identifier: MIT
// firmware/avr/hal/pixel_clock_isr.S in C for a board with several axes, as two/step_isr.c is of
// step_isr.S; comments name the labels. Interrupts are off from its beginning up to note_engine.
#include <avr/io.h>
#include <stdbool.h>

#include "avr/hal/capture_queue.h"
#include "avr/hal/clock_units.h" // clock_overflows
#include "avr/hal/flag_bits.h"
#include "avr/hal/step_isr.h"
#include "explore/part.h"
#include "explore/step_isr.h"

#define TIMER  part_registers.timers[CONFIG_PIXEL_CLOCK_AXIS]
#define ENGINE step_engines[CONFIG_PIXEL_CLOCK_AXIS]

static struct capture_queue *const queue = &pixel_clock_edges;

static bool is_set(uint8_t bit)
{
    return (GPIOR0 & _BV(bit)) != 0;
}

// macro note_engine; then interrupts are on.
static void note_engine(void)
{
    queue->first_left = ENGINE.left;
    queue->first_tail = ENGINE.tail;
    uint8_t low = *(const volatile uint8_t *)&ENGINE.idle_count;
    part_sei();
    queue->first_idle_low = low;
}

// .Lat_rest
static void note_parked(void)
{
    uint8_t unit = TCNT0;
    part_sei();
    queue->first_unit = unit;
    part_set_flag(FLAG_PIXEL_CLOCK_WRAPPED);
    queue->first_left = ENGINE.left;
    queue->first_tail = ENGINE.tail;
    queue->first_idle_low = *(const volatile uint8_t *)&ENGINE.idle_count;
}

// Up to .Lsaved
static void note_first(void)
{
    if ((TIMER.tifr & _BV(TOV1)) == 0) {
        note_engine();
        return;
    }
    queue->first_counter = TIMER.tcnt;
    TIMER.temp = ENGINE.train_high;
    if (is_set(FLAG_PIXEL_CLOCK_BEFORE)) {
        note_engine();
    } else if (ENGINE.state == STEP_ENGINE_PARKED) {
        note_parked();
    } else {
        note_engine();
        part_set_flag(FLAG_PIXEL_CLOCK_WRAPPED);
    }
}

// .Lparked: the coarse clock's low 16 bits, of the beginning if they were noted then.
static uint16_t parked_units(void)
{
    part_cli();
    struct clock_look look = clock_look();
    part_sei();
    uint16_t units = (uint16_t)clock_look_units(&look);

    if (is_set(FLAG_PIXEL_CLOCK_WRAPPED)) {
        uint8_t first = queue->first_unit;
        units = (uint16_t)(units - (uint8_t)((uint8_t)units - first));
    }
    return units;
}

// Behind .Lcounted_edge, up to .Lcomplete
static void place(struct captured_edge *entry, uint16_t ticks, uint16_t idle_count)
{
    uint8_t back = 1;

    entry->ticks = ticks;
    if (is_set(FLAG_PIXEL_CLOCK_WRAPPED) && queue->first_counter >= ticks) {
        back = 0;
    }
    uint8_t low = queue->first_idle_low;
    entry->idle_count = (uint16_t)(idle_count - (uint8_t)((uint8_t)idle_count - low));
    uint8_t tail = queue->first_tail;
    entry->tail = tail;
    int8_t left = queue->first_left;
    if (left == 0 && ENGINE.tail == tail) {
        int8_t cut = ENGINE.cut;
        if (cut != 0) {
            left = cut;
            back |= CAPTURED_EDGE_CUT;
        }
    }
    entry->left_or_cut = left;
    if (ENGINE.state == STEP_ENGINE_PARKED) {
        entry->idle_count = parked_units();
        back = CAPTURED_EDGE_WAS_PARKED;
    }
    entry->notes = back;
}

// find_place to publish
static void take_edge(void)
{
    uint8_t head = queue->head;

    if ((uint8_t)(queue->tail - head) == (uint8_t)-CONFIG_CLOCK_EDGES) {
        uint8_t lost = (uint8_t)(queue->lost + 1u);
        if (lost != 0) {
            queue->lost = lost;
        }
        return;
    }
    part_cli();
    uint16_t ticks = TIMER.icr;
    TIMER.temp = ENGINE.train_high;
    uint16_t idle_count = ENGINE.idle_count;
    uint8_t flags = TIMER.tifr;
    part_sei();
    if ((flags & _BV(ICF1)) != 0 || is_set(FLAG_PIXEL_CLOCK_SECOND)) {
        return;
    }
    place(&queue->entries[head & (CONFIG_CLOCK_EDGES - 1u)], ticks, idle_count);
    queue->head = (uint8_t)(queue->head + 1u);
}

void capture_isr(void)
{
    if (is_set(FLAG_PIXEL_CLOCK_BUSY)) {
        part_set_flag(FLAG_PIXEL_CLOCK_OVERRUN);
        part_set_flag(FLAG_PIXEL_CLOCK_SECOND);
        return;
    }
    part_set_flag(FLAG_PIXEL_CLOCK_BUSY);
    note_first();
    take_edge();
    part_clear_flag(FLAG_PIXEL_CLOCK_WRAPPED);
    part_cli();
    part_clear_flag(FLAG_PIXEL_CLOCK_BEFORE);
    part_clear_flag(FLAG_PIXEL_CLOCK_SECOND);
    part_clear_flag(FLAG_PIXEL_CLOCK_BUSY);
}
