// SPDX-License-Identifier: MIT
#include "account/ledger.h"

#include "base/apart.h"         // APART
#include "base/multiply.h"      // multiply_u32_u16
#include "build_features.h"     // FEATURE_BACKLASH, SEVERAL_AXES
#include "ring/step_ring_sum.h" // step_ring_sum

void ledger_reset(struct ledger *ledger, uint16_t first_period_ticks)
{
    *ledger = (struct ledger){0};
    play_reset(&ledger->play);
    ledger_restart(ledger, first_period_ticks);
}

APART void ledger_restart(struct ledger *ledger, uint16_t first_period_ticks)
{
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

static APART void shift_lengths(struct ledger *ledger, uint16_t newest_ticks, bool pulse)
{
    ledger->lengths[2] = ledger->lengths[1];
    ledger->lengths[1] = ledger->lengths[0];
    ledger->lengths[0] = newest_ticks;
    ledger->pulsed = (uint8_t)(ledger->pulsed << 1);
    if (pulse) {
        ledger->pulsed |= 1u;
    }
}

// Note the lengths of the fresh periods, which stand before the reader's end, while the ring still
// holds them: the slots may be written again once more periods are accounted for.
static void note_fresh(struct ledger *ledger, const struct stream *stream)
{
    for (; ledger->fresh != 0; ledger->fresh--) {
        // No command came after the fresh periods, so that they pulse as the last command said.
        shift_lengths(ledger, stream_passed_ticks(stream, ledger->fresh), ledger->pulse);
    }
}

uint32_t ledger_period_start(struct ledger *ledger,
                             const struct stream *stream,
                             uint8_t back)
{
    uint16_t loaded = ledger_train_loaded(ledger);
    uint8_t periods = (uint8_t)(back + 1u);
    uint32_t start = ledger->loaded_ticks;

    note_fresh(ledger, stream);
    if (loaded >= periods) {
        return start +
               stream_train_ticks(stream, ledger->train, (uint16_t)(loaded - periods));
    }
    uint8_t i = 0;

    // A handler may see an edge one period later than the lengths go: behind the last steps of a
    // fast train, which are equally long but for a tick.
    for (periods = (uint8_t)(periods - loaded); periods != 0; periods--) {
        start -= ledger->lengths[i];
        if (i != 2u) {
            i++;
        }
    }
    return start;
}

uint32_t ledger_capture_ticks(struct ledger *ledger,
                              const struct stream *stream,
                              uint8_t back,
                              uint16_t captured_ticks)
{
    uint16_t loaded = ledger_train_loaded(ledger);

    if (loaded > back && captured_ticks > stream_train_base(stream, ledger->train)) {
        back = (uint8_t)loaded;
    }
    note_fresh(ledger, stream);
    while (back >= loaded && back < loaded + 2u &&
           captured_ticks >= ledger->lengths[back - loaded]) {
        back++;
    }
    return ledger_period_start(ledger, stream, back) + captured_ticks;
}

uint8_t ledger_steps_after(struct ledger *ledger,
                           const struct stream *stream,
                           uint32_t ticks,
                           uint8_t edge_ticks)
{
    uint16_t loaded = ledger_train_loaded(ledger);
    uint8_t steps = 0;

    for (uint8_t back = 0; back < 3u; back++) {
        uint32_t edge = ledger_period_start(ledger, stream, back) + edge_ticks;
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
    BY_POINTER_SMALL(ledger);
    uint16_t origin = (uint16_t)origin_steps;

    ledger->position_steps -= origin_steps;
    ledger->line_origin -= origin_steps;
    if (ledger->negative) {
        origin = (uint16_t)-origin;
    }
    ledger->play.from = (uint16_t)(ledger->play.from - origin);
}

void ledger_cut(struct ledger *ledger, const struct stream *stream)
{
    note_fresh(ledger, stream);
    ledger->pulse = false;
}

static void ledger_begin_line(struct ledger *ledger, int32_t position_steps)
{
    ledger->line_origin = position_steps;
    if (ledger->pixel != 0) {
        ledger->lines_done++;
    }
    ledger->pixel = 0;
    records_reset(&ledger->records);
}

static void pass_waypoints(struct ledger *ledger, struct stream *stream)
{
    while (stream_has_waypoint(stream)) {
        const struct waypoint *waypoint = stream_waypoint(stream);
        uint8_t early = waypoint_early(waypoint);

        if (waypoint->slot != stream->retired || ledger->left > early) {
            return;
        }
        int32_t position_steps =
            ledger->position_steps + (ledger->negative ? (int8_t)early : -(int8_t)early);
        if (waypoint->way < WAYPOINT_START) {
            ledger_pass_edge(ledger, position_steps, waypoint->position);
        } else if (!SEVERAL_AXES || waypoint->way != WAYPOINT_PLACE) {
            ledger_begin_line(ledger, position_steps);
        }
        stream_pass_waypoint(stream);
    }
}

APART uint16_t ledger_settle_play(struct ledger *ledger)
{
    uint16_t place = (uint16_t)ledger->position_steps;

    if (ledger->negative) {
        place = (uint16_t)-place;
    }
    // What is left of a train may be cut off.
    return play_settle(&ledger->play, (uint16_t)(place - ledger->left));
}

static void ledger_execute(struct ledger *ledger, uint8_t command)
{
    if (command <= STEP_COMMAND_PULSE) {
        ledger->pulse = command == STEP_COMMAND_PULSE;
    } else if (command >= STEP_COMMAND_POSITIVE) {
        if (FEATURE_BACKLASH) {
            play_turn(&ledger->play, ledger_settle_play(ledger));
        }
        ledger->negative = command == STEP_COMMAND_NEGATIVE;
    } else if (command == STEP_COMMAND_END) {
        ledger->pulse = false;
    }
}

// Account for single periods.
static void take_periods(struct ledger *ledger, struct stream *stream, uint8_t tail)
{
    uint32_t ticks = 0;
    uint8_t count = stream_pass_periods(stream, tail, &ticks);

    ledger->loaded_ticks += ticks;
    ledger_pass_periods(ledger, count);
}

// Note the last intervals of a train that is over, backwards from the interrupt's sum: an interval
// was a long one if and only if it left a sum below the least that a short one leaves.
static void note_lengths(struct ledger *ledger,
                         const struct stream *stream,
                         uint16_t loaded)
{
    BY_POINTER_SMALL(ledger);
    const struct pulse_train *carried = &stream->engine_trains[ledger->train];
    uint16_t base = stream_train_base(stream, ledger->train);
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

// The train is over after so many of its steps: account for its length and free it.
static APART void close_train(struct ledger *ledger,
                              struct stream *stream,
                              uint16_t loaded,
                              uint32_t ticks)
{
    note_lengths(ledger, stream, loaded);
    ledger->loaded_ticks += ticks;
    stream_free_train(stream, ledger->train);
    ledger->train = LEDGER_NO_TRAIN;
    ledger->train_steps = 0;
    ledger->left = 0;
}

static APART_LARGE void arrive_in_train(struct ledger *ledger,
                                        struct stream *stream,
                                        const struct engine_sample *sample)
{
    BY_POINTER_SMALL(ledger);
    uint16_t loaded = ledger->train_steps;

    ledger->left = stream->retired == sample->tail ? sample->left : 0;
    if (ledger->left == 0 && loaded == stream->trains[ledger->train].steps) {
        close_train(
            ledger, stream, loaded, stream_train_ticks(stream, ledger->train, loaded));
    }
}

// The rest of the train was cut off: close it. An edge in the rest of the entry is never passed;
// what is left of the entry tells, and the waypoints of this slot were passed by that.
static APART_LARGE void cut_train(struct ledger *ledger, struct stream *stream)
{
    BY_POINTER_SMALL(ledger);
    uint16_t loaded = ledger_train_loaded(ledger);

    stream_forget_waypoints(stream);
    ledger->position_steps = ledger_position(ledger);
    close_train(
        ledger, stream, loaded, stream_train_ticks(stream, ledger->train, loaded));
}

// The account has come to slot `retired`, where the interrupt reads next unless the account lags:
// close a train that is over, and pass the waypoints of this slot.
static inline void ledger_arrive(struct ledger *ledger,
                                 struct stream *stream,
                                 const struct engine_sample *sample)
{
    if (ledger->train != LEDGER_NO_TRAIN) {
        arrive_in_train(ledger, stream, sample);
    }
    if (stream_waypoint_within(stream, 0)) {
        pass_waypoints(ledger, stream);
    }
}

// Account for a command, or for entries of a pulse train up to the interrupt or the next waypoint.
static void take_special(struct ledger *ledger,
                         struct stream *stream,
                         uint8_t tail,
                         uint8_t kind)
{
    note_fresh(ledger, stream);
    uint8_t low = stream_pass_entry(stream);

    if (kind == STEP_HIGH_COMMAND) {
        ledger_execute(ledger, low);
        return;
    }
    uint8_t train = stream_entry_train((int8_t)low);
    uint16_t steps = stream_entry_steps((int8_t)low);

    // A single axis has the time to pass them one by one.
    if (SEVERAL_AXES) {
        steps = (uint16_t)(steps + stream_pass_train(stream, train, tail));
    }
    ledger->train = train;
    ledger->train_steps = (uint16_t)(ledger->train_steps + steps);
    ledger_move_position(ledger, steps);
}

// Account for idle periods, all at once however many. They come after the entries: the interrupt
// loads idle periods only when the ring is empty, and a new line is released only after a
// ledger_advance() that saw every idle period before that line.
static void add_idle(struct ledger *ledger, struct stream *stream, uint16_t idle_count)
{
    uint16_t count = (uint16_t)(idle_count - ledger->idle_seen);

    if (count == 0) {
        return;
    }
    uint32_t ticks = multiply_u32_u16(STEP_IDLE_TICKS, count);

    note_fresh(ledger, stream);
    for (uint8_t i = count < 3u ? (uint8_t)count : 3u; i != 0; i--) {
        shift_lengths(ledger, STEP_IDLE_TICKS, false);
    }
    ledger->idle_seen = idle_count;
    ledger->loaded_ticks += ticks;
    stream_delay(stream, ticks);
}

// Account for the entries at this place, up to the interrupt or to the next waypoint.
static void take_entries(struct ledger *ledger, struct stream *stream, uint8_t tail)
{
    uint8_t kind = stream_peek(stream);

    if (kind >= STEP_HIGH_TRAIN) {
        take_special(ledger, stream, tail, kind);
    } else {
        take_periods(ledger, stream, tail);
    }
}

// Returns false when the rest is left to be passed by a waypoint later.
static APART_LARGE bool advance_by_entries(struct ledger *ledger,
                                           struct stream *stream,
                                           const struct engine_sample *sample,
                                           bool whole)
{
    for (;;) {
        ledger_arrive(ledger, stream, sample);
        if (stream->retired == sample->tail) {
            return true;
        }
        if (ledger_advance_plain(ledger, stream, sample->tail) && whole) {
            return false;
        }
        if (stream->retired != sample->tail) {
            take_entries(ledger, stream, sample->tail);
        }
    }
}

// True unless an idle period or a cut has come: behind those nothing is left to be passed later.
static inline bool goes_on(const struct ledger *ledger,
                           const struct engine_sample *sample)
{
    return !sample->cut && sample->idle_count == ledger->idle_seen;
}

void ledger_advance(struct ledger *ledger,
                    struct stream *stream,
                    const struct engine_sample *sample,
                    enum ledger_extent extent)
{
    bool whole = extent == LEDGER_BY_WAYPOINTS && goes_on(ledger, sample);

    if (!advance_by_entries(ledger, stream, sample, whole)) {
        return;
    }
    if (sample->cut && ledger->left != 0) {
        cut_train(ledger, stream);
    }
    add_idle(ledger, stream, sample->idle_count);
}

int32_t ledger_position_at(const struct ledger *ledger,
                           const struct stream *stream,
                           uint8_t tail)
{
    uint8_t slot = stream->retired;
    int32_t position = ledger_position(ledger);

    if (!ledger->pulse) {
        return position;
    }
    if (stream_on_plain_way(stream, tail)) {
        slot = tail;
    } else {
        (void)step_ring_sum(stream->ring, &slot, tail);
    }
    uint8_t steps = (uint8_t)(slot - stream->retired);
    return ledger->negative ? position - steps : position + steps;
}

// Start of the period at this slot, one of the single periods around the place that the account has
// come to. ahead: it is not accounted for yet.
static uint32_t start_beside(const struct ledger *ledger,
                             const struct stream *stream,
                             uint8_t slot,
                             bool ahead)
{
    uint8_t from = ahead ? stream->retired : slot;
    uint8_t to = ahead ? slot : stream->retired;
    uint32_t ticks = step_ring_sum(stream->ring, &from, to);

    return ahead ? ledger->loaded_ticks + ticks : ledger->loaded_ticks - ticks;
}

// Start of period `back`, or of the first one before it that is as long as the captured count,
// among the single periods around this place that still stand in the ring. False if it is none of
// them.
static bool start_in_ring(const struct ledger *ledger,
                          const struct stream *stream,
                          uint8_t tail,
                          uint8_t back,
                          uint16_t captured_ticks,
                          uint32_t *start_ticks)
{
    uint8_t ahead = (uint8_t)(tail - stream->retired);
    uint8_t known = (uint8_t)(ahead + ledger->fresh);

    for (uint8_t at = back; at < known; at++) {
        uint8_t slot = (uint8_t)(tail - 1u - at);
        if (captured_ticks < stream_entry_ticks(stream, slot)) {
            *start_ticks = start_beside(ledger, stream, slot, at < ahead);
            return true;
        }
    }
    return false;
}

// Start of the period that the interrupt of an axis at rest was in, by a sample that is not
// accounted for yet.
static uint32_t idle_start(const struct ledger *ledger,
                           const struct engine_sample *sample)
{
    uint16_t count = (uint16_t)(sample->idle_count - ledger->idle_seen);

    return ledger->loaded_ticks - (uint32_t)(2u * STEP_IDLE_TICKS) +
           multiply_u32_u16(STEP_IDLE_TICKS, count);
}

// Apart from the quick way of ledger_capture.S, which boards of several axes take first.
#if defined(__AVR__) && SEVERAL_AXES
#define TO_CAPTURE ledger_capture_anywhere
#else
#define TO_CAPTURE ledger_advance_to_capture
#endif

APART uint32_t TO_CAPTURE(struct ledger *ledger,
                          struct stream *stream,
                          const struct engine_sample *sample,
                          uint8_t back,
                          uint16_t captured_ticks)
{
    uint32_t start_ticks = 0;

    // Most edges come while the clock's axis rests, or among single periods.
    if (SEVERAL_AXES && back == 1 && stream->retired == sample->tail &&
        ledger_idles(ledger)) {
        return idle_start(ledger, sample) + captured_ticks;
    }
    ledger_advance(ledger, stream, sample, LEDGER_BY_WAYPOINTS);
    if (start_in_ring(ledger, stream, sample->tail, back, captured_ticks, &start_ticks)) {
        return start_ticks + captured_ticks;
    }
    // Of few steps a pixel the waypoints have often passed all.
    if (stream->retired != sample->tail) {
        ledger_advance(ledger, stream, sample, LEDGER_EXACTLY);
    }
    return ledger_capture_ticks(ledger, stream, back, captured_ticks);
}
