// SPDX-License-Identifier: MIT
#include "motion/ledger.h"

void ledger_reset(struct ledger *ledger,
                  struct step_ring *ring,
                  uint16_t first_period_ticks)
{
    *ledger = (struct ledger){.ring = ring};
    ledger_restart(ledger, first_period_ticks);
}

void ledger_restart(struct ledger *ledger, uint16_t first_period_ticks)
{
    ledger->retired = 0;
    ledger->pulse = false;
    ledger->idle_seen = 0;
    ledger->loaded_ticks = 2uL * first_period_ticks;
    ledger->lengths[0] = first_period_ticks;
    ledger->lengths[1] = first_period_ticks;
}

void ledger_note_edge_error(struct ledger *ledger, uint32_t pixel, int16_t error_ticks)
{
    for (uint8_t i = 0; i < ledger->record_count; i++) {
        if (ledger->records[i].pixel == (uint16_t)pixel) {
            ledger->records[i].edge_error_ticks = error_ticks;
        }
    }
}

uint32_t ledger_period_start(const struct ledger *ledger, uint8_t back)
{
    uint32_t start = ledger->loaded_ticks;

    for (uint8_t i = 0; i <= back; i++) {
        start -= ledger->lengths[i];
    }
    return start;
}

void ledger_skip_to(struct ledger *ledger, uint8_t slot)
{
    ledger->retired = slot;
    ledger->pulse = false;
}

static void add_period(struct ledger *ledger, uint16_t ticks)
{
    ledger->lengths[2] = ledger->lengths[1];
    ledger->lengths[1] = ledger->lengths[0];
    ledger->lengths[0] = ticks;
    ledger->loaded_ticks += ticks;
}

static void pass_edge(struct ledger *ledger, const struct feed_mark *mark)
{
    struct pixel_record *record = &ledger->records[ledger->record_next];

    ledger->pixel++;
    record->pixel = (uint16_t)ledger->pixel;
    record->edge_error_ticks = 0;
    record->expected_steps = mark->position;
    record->actual_steps = ledger->position_steps - ledger->line_origin;
    ledger->record_next = (uint8_t)(ledger->record_next + 1u);
    if (ledger->record_next == LEDGER_RECORDS) {
        ledger->record_next = 0;
    }
    if (ledger->record_count < LEDGER_RECORDS) {
        ledger->record_count++;
    }
}

static void begin_line(struct ledger *ledger)
{
    ledger->line_origin = ledger->position_steps;
    ledger->pixel = 0;
    ledger->record_next = 0;
    ledger->record_count = 0;
}

static void pass_marks(struct ledger *ledger, struct feed *feed)
{
    while (feed->mark_tail != feed->mark_placed) {
        const struct feed_mark *mark = &feed->marks[feed->mark_tail & (FEED_MARKS - 1u)];

        if (mark->slot != ledger->retired) {
            return;
        }
        if (mark->line_start) {
            begin_line(ledger);
        } else {
            pass_edge(ledger, mark);
        }
        feed->mark_tail++;
    }
}

static void obey(struct ledger *ledger, uint8_t command)
{
    if (command <= STEP_COMMAND_PULSE) {
        ledger->pulse = command == STEP_COMMAND_PULSE;
    } else if (command >= STEP_COMMAND_POSITIVE) {
        ledger->negative = command == STEP_COMMAND_NEGATIVE;
    } else if (command == STEP_COMMAND_END) {
        ledger->pulse = false;
    }
}

// Periods up to a command or the given slot: the frequent case, in registers.
static void take_periods(struct ledger *ledger, uint8_t stop)
{
    const struct step_ring *ring = ledger->ring;
    uint32_t loaded = ledger->loaded_ticks;
    uint16_t newest = ledger->lengths[0];
    uint16_t second = ledger->lengths[1];
    uint16_t third = ledger->lengths[2];
    uint8_t slot = ledger->retired;
    uint8_t first = slot;

    for (; slot != stop; slot++) {
        uint8_t high = ring->high[slot];
        if (high == STEP_HIGH_COMMAND) {
            break;
        }
        third = second;
        second = newest;
        newest = (uint16_t)((uint16_t)(((uint16_t)high << 8) | ring->low[slot]) + 1u);
        loaded += newest;
    }
    uint8_t count = (uint8_t)(slot - first);
    ledger->taken_ticks += loaded - ledger->loaded_ticks;
    ledger->loaded_ticks = loaded;
    ledger->lengths[0] = newest;
    ledger->lengths[1] = second;
    ledger->lengths[2] = third;
    ledger->retired = slot;
    if (ledger->pulse) {
        ledger->position_steps += ledger->negative ? -(int16_t)count : (int16_t)count;
    }
}

// The next mark's slot if it comes before the given one, else that one.
static uint8_t next_stop(const struct ledger *ledger,
                         const struct feed *feed,
                         uint8_t tail)
{
    if (feed->mark_tail == feed->mark_placed) {
        return tail;
    }
    uint8_t slot = feed->marks[feed->mark_tail & (FEED_MARKS - 1u)].slot;
    bool sooner = (uint8_t)(slot - ledger->retired) < (uint8_t)(tail - ledger->retired);

    return sooner ? slot : tail;
}

void ledger_follow(struct ledger *ledger, struct feed *feed, struct engine_sample sample)
{
    if (feed->mark_tail != feed->mark_placed) {
        pass_marks(ledger, feed);
    }
    while (ledger->retired != sample.tail) {
        uint8_t stop = next_stop(ledger, feed, sample.tail);
        take_periods(ledger, stop);
        if (ledger->retired != stop) {
            obey(ledger, ledger->ring->low[ledger->retired]);
            ledger->retired++;
        }
        if (feed->mark_tail != feed->mark_placed) {
            pass_marks(ledger, feed);
        }
    }
    // Idle periods come after the entries: they are loaded only when the ring is empty, and a new
    // line is released only after a ledger_follow() that saw every idle period before it.
    while (ledger->idle_seen != sample.idle_count) {
        ledger->idle_seen++;
        add_period(ledger, STEP_IDLE_TICKS);
    }
}
