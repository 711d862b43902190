// SPDX-License-Identifier: MIT
#include "motion/ledger.h"

#include "base/apart.h"           // APART
#include "motion/step_ring_sum.h" // step_ring_sum

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
    ledger->left = 0;
    ledger->fresh = 0;
    ledger->pulsed = 0;
    ledger->train = LEDGER_NO_TRAIN;
    ledger->train_steps = 0;
    ledger->idle_seen = 0;
    ledger->loaded_ticks = 2uL * first_period_ticks;
    ledger->lengths[0] = first_period_ticks;
    ledger->lengths[1] = first_period_ticks;
}

void ledger_note_edge_error(struct ledger *ledger, uint32_t pixel, int16_t error_ticks)
{
    records_note_error(&ledger->records, (uint16_t)pixel, error_ticks);
}

static void shift_lengths(struct ledger *ledger, uint16_t newest_ticks, bool pulse)
{
    ledger->lengths[2] = ledger->lengths[1];
    ledger->lengths[1] = ledger->lengths[0];
    ledger->lengths[0] = newest_ticks;
    ledger->pulsed = (uint8_t)(ledger->pulsed << 1);
    if (pulse) {
        ledger->pulsed |= 1u;
    }
}

// Note the lengths of the fresh periods while the ring still holds them: their slots may be written
// again as soon as the next periods are accounted for.
static void note_fresh(struct ledger *ledger)
{
    const struct step_ring *ring = ledger->ring;

    for (; ledger->fresh != 0; ledger->fresh--) {
        uint8_t at = (uint8_t)(ledger->retired - ledger->fresh);
        uint16_t top_ticks = (uint16_t)(ring->high[at] << 8);
        // No command came after the fresh periods, so that they pulse as the last command said.
        uint16_t ticks = (uint16_t)(top_ticks + ring->low[at] + 1u);
        shift_lengths(ledger, ticks, ledger->pulse);
    }
}

uint32_t ledger_period_start(struct ledger *ledger, const struct feed *feed, uint8_t back)
{
    uint16_t loaded = ledger_train_loaded(ledger);
    uint8_t periods = (uint8_t)(back + 1u);
    uint32_t start = ledger->loaded_ticks;

    note_fresh(ledger);
    if (loaded >= periods) {
        return start +
               feed_train_ticks(feed, ledger->train, (uint16_t)(loaded - periods));
    }
    for (uint8_t i = 0; i < (uint8_t)(periods - loaded); i++) {
        start -= ledger->lengths[i];
    }
    return start;
}

uint32_t ledger_capture_ticks(struct ledger *ledger,
                              const struct feed *feed,
                              uint8_t back,
                              uint16_t captured_ticks)
{
    uint16_t loaded = ledger_train_loaded(ledger);

    if (loaded > back && captured_ticks > feed_train_base(feed, ledger->train)) {
        back = (uint8_t)loaded;
    }
    return ledger_period_start(ledger, feed, back) + captured_ticks;
}

uint8_t ledger_steps_after(struct ledger *ledger,
                           const struct feed *feed,
                           uint32_t ticks,
                           uint8_t edge_ticks)
{
    uint16_t loaded = ledger_train_loaded(ledger);
    uint8_t steps = 0;

    for (uint8_t back = 0; back < 3u; back++) {
        uint32_t edge = ledger_period_start(ledger, feed, back) + edge_ticks;
        bool pulsed = back < loaded;
        if (!pulsed) {
            pulsed = (ledger->pulsed & (1u << (uint8_t)(back - loaded))) != 0;
        }
        if (pulsed && (int32_t)(edge - ticks) > 0) {
            steps++;
        }
    }
    return steps;
}

void ledger_zero(struct ledger *ledger, int32_t origin_steps)
{
    ledger->position_steps -= origin_steps;
    ledger->line_origin -= origin_steps;
}

void ledger_skip_to(struct ledger *ledger, uint8_t slot)
{
    note_fresh(ledger);
    ledger->retired = slot;
    ledger->pulse = false;
}

static void add_quiet_period(struct ledger *ledger, uint16_t ticks)
{
    note_fresh(ledger);
    shift_lengths(ledger, ticks, false);
    ledger->loaded_ticks += ticks;
}

static APART int32_t position_at(const struct ledger *ledger,
                                 const struct feed_mark *mark)
{
    return ledger->position_steps +
           (ledger->negative ? (int8_t)mark->early : -(int8_t)mark->early);
}

static void pass_edge(struct ledger *ledger, const struct feed_mark *mark)
{
    ledger->pixel++;
    records_add(&ledger->records,
                (uint16_t)ledger->pixel,
                position_at(ledger, mark) - ledger->line_origin,
                mark->position);
}

static void ledger_begin_line(struct ledger *ledger, const struct feed_mark *mark)
{
    ledger->line_origin = position_at(ledger, mark);
    ledger->pixel = 0;
    records_reset(&ledger->records);
}

static void pass_marks(struct ledger *ledger, struct feed *feed)
{
    while (feed->mark_tail != feed->mark_placed) {
        const struct feed_mark *mark = &feed->marks[feed->mark_tail & (FEED_MARKS - 1u)];

        if (mark->slot != ledger->retired || ledger->left > mark->early) {
            return;
        }
        if (mark->line_start) {
            ledger_begin_line(ledger, mark);
        } else {
            pass_edge(ledger, mark);
        }
        feed->mark_tail++;
    }
}

static void ledger_execute(struct ledger *ledger, uint8_t command)
{
    if (command <= STEP_COMMAND_PULSE) {
        ledger->pulse = command == STEP_COMMAND_PULSE;
    } else if (command >= STEP_COMMAND_POSITIVE) {
        ledger->negative = command == STEP_COMMAND_NEGATIVE;
    } else if (command == STEP_COMMAND_END) {
        ledger->pulse = false;
    }
}

static void count_periods(struct ledger *ledger, uint8_t count, uint32_t ticks)
{
    uint8_t fresh = (uint8_t)(ledger->fresh + (count < 3u ? count : 3u));

    // With fewer than three new periods some earlier ones are still among the last three.
    if (fresh > 3u) {
        note_fresh(ledger);
        fresh = count < 3u ? count : 3u;
    }
    ledger->fresh = fresh;
    ledger->taken_ticks += ticks;
    ledger->loaded_ticks += ticks;
    ledger->retired = (uint8_t)(ledger->retired + count);
    if (ledger->pulse) {
        ledger->position_steps += ledger->negative ? -(int16_t)count : (int16_t)count;
    }
}

// Account for single periods, one by one, up to slot `stop` or an entry of another kind. Returns
// their length, ticks.
static uint32_t walk_periods(struct ledger *ledger, uint8_t stop)
{
    uint8_t slot = ledger->retired;
    uint32_t ticks = step_ring_sum(ledger->ring, &slot, stop);
    uint8_t count = (uint8_t)(slot - ledger->retired);

    if (count != 0) {
        count_periods(ledger, count, ticks);
    }
    return ticks;
}

// Account for the block at `retired`: for the whole block, or for its periods before slot `stop`.
static void take_block(struct ledger *ledger,
                       struct feed *feed,
                       struct feed_block *block,
                       uint8_t stop)
{
    uint8_t count = (uint8_t)(stop - ledger->retired);

    if (count >= block->count) {
        count_periods(ledger, block->count, block->ticks);
        feed_drop_block(feed);
    } else {
        block->ticks -= walk_periods(ledger, stop);
        block->slot = stop;
        block->count = (uint8_t)(block->count - count);
    }
}

// Account for single periods up to slot `stop`, an entry of another kind or the start or end of a
// block.
static void take_periods(struct ledger *ledger, struct feed *feed, uint8_t stop)
{
    struct feed_block *block = feed_next_block(feed);
    uint8_t to_stop = (uint8_t)(stop - ledger->retired);

    if (block != NULL && block->slot == ledger->retired && to_stop != 0) {
        take_block(ledger, feed, block, stop);
    } else if (block != NULL && (uint8_t)(block->slot - ledger->retired) < to_stop) {
        (void)walk_periods(ledger, block->slot);
    } else {
        (void)walk_periods(ledger, stop);
    }
}

// The next mark's slot if it comes before slot `tail`, else `tail`.
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

// The train is over: account for its length and free it.
static APART void pass_train(struct ledger *ledger,
                             struct feed_train *train,
                             uint32_t ticks)
{
    ledger->loaded_ticks += ticks;
    ledger->taken_ticks += ticks;
    ledger->train = LEDGER_NO_TRAIN;
    ledger->train_steps = 0;
    ledger->left = 0;
    train->steps = 0;
}

// Note the last intervals of a train that is over, backwards from the interrupt's sum: an interval
// was a long one if and only if it left a sum below the least that a short one leaves.
static void note_lengths(struct ledger *ledger, const struct feed *feed, uint16_t loaded)
{
    const struct pulse_train *carried = &feed->engine_trains[ledger->train];
    uint16_t base = feed_train_base(feed, ledger->train);
    int16_t sum = carried->sum;
    uint8_t count = loaded < 3u ? (uint8_t)loaded : 3u;

    for (uint8_t i = 3; i > count; i--) {
        ledger->lengths[i - 1u] = ledger->lengths[i - 1u - count];
    }
    // A pixel's steps fit 15 bits, so both terms and their sum do.
    int16_t least = (int16_t)(carried->after_short + carried->after_long);

    for (uint8_t i = 0; i < count; i++) {
        int16_t after = carried->after_short;
        ledger->pulsed = (uint8_t)(ledger->pulsed << 1) | 1u;
        ledger->lengths[i] = base;
        if (sum < least) {
            after = carried->after_long;
            ledger->lengths[i]++;
        }
        sum = (int16_t)(sum - after);
    }
}

// Close the train when all of it was loaded, or when its rest was cut off.
static void settle_train(struct ledger *ledger, struct feed *feed, bool cut)
{
    struct feed_train *train = &feed->trains[ledger->train];

    if (cut && ledger->left != 0) {
        uint16_t loaded = ledger_train_loaded(ledger);
        ledger->position_steps = ledger_position(ledger);
        note_lengths(ledger, feed, loaded);
        pass_train(ledger, train, feed_train_ticks(feed, ledger->train, loaded));
    } else if (ledger->left == 0 && ledger->train_steps == train->steps) {
        note_lengths(ledger, feed, train->steps);
        pass_train(ledger, train, train->ticks);
    }
}

static void __attribute__((noinline)) arrive_in_train(struct ledger *ledger,
                                                      struct feed *feed,
                                                      const struct engine_sample *sample)
{
    ledger->left = ledger->retired == sample->tail ? sample->left : 0;
    settle_train(ledger, feed, sample->cut);
}

// The account has come to slot `retired`, where the interrupt reads next unless the account lags:
// close a train that is over, and pass the marks of this slot.
static inline void ledger_arrive(struct ledger *ledger,
                                 struct feed *feed,
                                 const struct engine_sample *sample)
{
    if (ledger->train != LEDGER_NO_TRAIN) {
        arrive_in_train(ledger, feed, sample);
    }
    if (ledger_mark_here(ledger, feed)) {
        pass_marks(ledger, feed);
    }
}

// Account for a command or for one entry of a pulse train.
static void take_special(struct ledger *ledger)
{
    note_fresh(ledger);
    uint8_t low = ledger->ring->low[ledger->retired];

    if (ledger->ring->high[ledger->retired] == STEP_HIGH_COMMAND) {
        ledger_execute(ledger, low);
    } else {
        int8_t count = (int8_t)low;
        uint8_t steps = (uint8_t)(count < 0 ? -count : count);
        ledger->train = count < 0 ? 1 : 0;
        ledger->train_steps = (uint16_t)(ledger->train_steps + steps);
        ledger->position_steps += ledger->negative ? -(int16_t)steps : (int16_t)steps;
    }
    ledger->retired++;
}

static void add_idle(struct ledger *ledger, uint16_t idle_count)
{
    // Idle periods come after the entries: the interrupt loads idle periods only when the ring is
    // empty, and a new line is released only after a ledger_follow() that saw every idle period
    // before that line.
    while (ledger->idle_seen != idle_count) {
        ledger->idle_seen++;
        add_quiet_period(ledger, STEP_IDLE_TICKS);
    }
}

// True when the next entry is a command or belongs to a pulse train.
static bool at_special(const struct ledger *ledger, uint8_t tail)
{
    return ledger->retired != tail &&
           ledger->ring->high[ledger->retired] >= STEP_HIGH_TRAIN;
}

void ledger_follow(struct ledger *ledger,
                   struct feed *feed,
                   const struct engine_sample *sample)
{
    ledger_arrive(ledger, feed, sample);
    while (ledger->retired != sample->tail) {
        if (at_special(ledger, sample->tail)) {
            take_special(ledger);
        } else {
            take_periods(ledger, feed, next_stop(ledger, feed, sample->tail));
        }
        ledger_arrive(ledger, feed, sample);
    }
    add_idle(ledger, sample->idle_count);
}

// The frequent case, since blocks hold the steps of curves: account for whole blocks that are over.
static void take_blocks(struct ledger *ledger, struct feed *feed, uint8_t tail)
{
    uint32_t ticks = 0;
    uint8_t count = 0;
    uint8_t behind = (uint8_t)(tail - ledger->retired);

    for (;;) {
        const struct feed_block *block = feed_next_block(feed);
        uint8_t slot = (uint8_t)(ledger->retired + count);
        if (block == NULL || block->slot != slot ||
            block->count > (uint8_t)(behind - count)) {
            break;
        }
        // No pixel edge lies between this block and the one before it: neither the step before an
        // edge nor the step behind it is ever in a block (feed_plain() and put_chunk() in feed.c).
        ticks += block->ticks;
        count = (uint8_t)(count + block->count);
        feed_drop_block(feed);
    }
    if (count != 0) {
        count_periods(ledger, count, ticks);
    }
}

// Follow entry by entry, but leave a block alone that the interrupt has not finished.
static void follow_to_block(struct ledger *ledger,
                            struct feed *feed,
                            const struct engine_sample *sample)
{
    ledger_arrive(ledger, feed, sample);
    while (ledger->retired != sample->tail &&
           !ledger_inside_block(ledger, feed, sample->tail)) {
        if (at_special(ledger, sample->tail)) {
            take_special(ledger);
        } else {
            take_periods(ledger, feed, next_stop(ledger, feed, sample->tail));
        }
        ledger_arrive(ledger, feed, sample);
    }
}

void ledger_follow_blocks(struct ledger *ledger,
                          struct feed *feed,
                          const struct engine_sample *sample)
{
    // After an idle period or a cut no block is left to be accounted for as a whole later.
    if (FEED_BLOCKS == 0 || sample->cut || sample->idle_count != ledger->idle_seen) {
        ledger_follow(ledger, feed, sample);
        return;
    }
    if (ledger->train == LEDGER_NO_TRAIN) {
        take_blocks(ledger, feed, sample->tail);
        if (!ledger_mark_here(ledger, feed) &&
            (ledger->retired == sample->tail ||
             ledger_inside_block(ledger, feed, sample->tail))) {
            return;
        }
    }
    follow_to_block(ledger, feed, sample);
}
