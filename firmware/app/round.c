// SPDX-License-Identifier: MIT
#include "app/round.h"

#include "app/axes/axes.h"          // axes_*
#include "app/axes/faults.h"        // faults_latch
#include "app/axes/gate.h"          // gate_arms_next
#include "app/axes/reference.h"     // reference_pixel
#include "app/bus/bus_port.h"       // bus_port_brings_data
#include "app/motion/clock_edges.h" // clock_edges_*
#include "app/motion/parking.h"     // parking_poll
#include "app/motion/seek.h"        // seek_poll
#include "app/motion/start.h"       // start_near, start_poll
#include "app/registers/commands.h" // commands_arm_next
#include "app/settings/store.h"     // store_poll
#include "app/watch/drivers.h"      // drivers_poll
#include "app/watch/inputs.h"       // inputs_poll
#include "app/watch/safety.h"       // safety_poll
#include "app/watch/time_check.h"   // time_check_poll
#include "app/watch/witness.h"      // witness_poll
#include "axis/decode.h"            // decode_*
#include "base/apart.h"             // APART
#include "hal/clock.h"              // clock_now_units
#include "hal/cpu.h"                // cpu_section
#include "hal/estop.h"              // estop_latched
#include "hal/step_timer.h"         // step_timer_*

// Cost of the steps that one call of the decoder may take.
#define DECODE_AT_ONCE 120u
// The same while an axis waits for its release: the release must come within a few milliseconds.
#define DECODE_AT_ONCE_STARTING 12u
// Several axes are decoded for one after the other until so much time is over, interrupts included,
// microseconds: with shorter rounds their other work would cost too much, with longer ones bus,
// switches and releases would wait for too long.
#define DECODE_US 4000u
// So many calls come first even where the bus brings entries of lines, or waits in the middle of a
// request.
#define DECODE_CALLS_LEAST 2u
// What is decoded for an axis is enough for now when its last period begins so much later: the
// board looks again within 4,000 cycles, interrupts not counted, and may then decode for other axes
// first: it is the time of a long turn of the decoder. More is not needed: what is decoded in the
// middle of a request holds up its reply, and the bytes that follow.
#define ENOUGH_TICKS ((uint32_t)(CONFIG_TIMER_HZ / 1000uL * (DECODE_US / 1000u)))
// The switches of every axis are read once in this many rounds; those of a seeking axis, in every
// round.
#define INPUT_ROUNDS 4u

// Attempts to release an axis in one round. Edges that come faster than they can be taken must not
// hold the main loop.
#define RELEASE_TRIES 4u

// Accounts are advanced in turn, one axis every ADVANCE_ROUNDS rounds, and out of turn when an
// account lags this many entries behind. Nothing else looks for the end of a single axis's train.
#define ADVANCE_ENTRIES 64u
#define ADVANCE_ROUNDS  (CONFIG_AXES > 1 ? 8u : 4u)

static uint8_t rounds; // counts rounds, for work that serves one axis after the other

void round_start(void)
{
    rounds = 0;
}

static void take_underruns(void)
{
    for (uint8_t i = 0; step_timer_underrun() && i < CONFIG_AXES; i++) {
        if (step_timer_take_underrun(i)) {
            faults_latch_underrun(i);
        }
    }
}

// The fault that halted the axis. The emergency stop may have halted it before this round has
// noticed the stop.
static enum fault why_halted(const struct axis *axis)
{
    if (estop_latched()) {
        return FAULT_estop;
    }
    return axis->phase == DECODE_DRY ? FAULT_starved : FAULT_decoder_late;
}

// Latch the fault of an axis that halted. An underrun halts an axis as well, and may have come
// since this round took the underruns.
static void name_halt(uint8_t i)
{
    take_underruns();
    if (axes_get(i)->life.state == AXIS_RUNNING) {
        enum fault why = why_halted(axes_get(i));
        // An emergency stop halts them all.
        if (CONFIG_AXES > 1 && why == FAULT_estop) {
            i = CONFIG_INDEX(axes_first_moving());
        }
        (void)axes_advance(i, LEDGER_EXACTLY);
        faults_latch_plain(why, i);
    }
}

// Look after a running axis: it may have halted or come to the end of its line.
static void supervise_running(uint8_t i)
{
    struct axis *axis = axes_get(i);

    if (step_timer_state(i) == STEP_ENGINE_HALTED) {
        name_halt(i);
    } else if (axis->phase == DECODE_OUTSIDE && axis_ring_fill(axis) == 0 &&
               step_timer_state(i) == STEP_ENGINE_IDLE && time_check_passes(i)) {
        // No period was made twice near the end: the line has no step too many.
        axis_line_finished(axis);
        gate_line_done(i);
        if (gate_arms_next(i)) {
            commands_arm_next(i);
        }
    }
}

// Look after an axis that is stopping. What it made twice on its way is named before it counts as
// stopped.
#if CONFIG_AXES > 1
static APART void supervise_stopping(uint8_t i)
{
    if (!step_engine_going(step_timer_state(i))) {
        (void)time_check_passes(i);
    }
    axes_stop(i);
}
#else
static void supervise_stopping(uint8_t i)
{
    axes_stop(i);
}
#endif

static void supervise_axis(uint8_t i)
{
    uint8_t state = axes_get(i)->life.state;

    if (state == AXIS_RUNNING) {
        supervise_running(i);
        return;
    }
    if (state == AXIS_STOPPING) {
        supervise_stopping(i);
    }
    witness_poll(i);
}

// True when the decoder waits for much room in the ring. With one axis its turn comes soon enough.
static inline bool awaits_room(const struct axis *axis)
{
    uint8_t room = axis->line.room;

    return CONFIG_AXES > 1 && room > ADVANCE_ENTRIES &&
           stream_space(&axis->feed.stream) < room;
}

// True when the interrupt, which reads slot `tail` next, has made as many periods as take up the
// room that the decoder waits for.
static inline bool room_may_be_free(const struct axis *axis, uint8_t tail)
{
    const struct stream *stream = &axis->feed.stream;

    return awaits_room(axis) && (uint8_t)(tail - stream->retired) >=
                                    (uint8_t)(axis->line.room - stream_space(stream));
}

// True when the account of an axis, whose interrupt reads slot `tail` next, must be advanced out of
// turn.
static inline bool is_urgent(const struct axis *axis, uint8_t tail)
{
    const struct stream *stream = &axis->feed.stream;

    // Full waypoints keep the decoder from the next pixel.
    return (uint8_t)(tail - stream->retired) >= ADVANCE_ENTRIES ||
           stream_waypoints_full(stream) || room_may_be_free(axis, tail);
}

// Advance the account of one axis after the other now and then, and out of turn where there is much
// to account for: after a few steps this would cost more than these steps are worth.
static void advance_in_turn(void)
{
    uint8_t due = CONFIG_AXES;

    rounds++;
    if (rounds % ADVANCE_ROUNDS == 0) {
        due = rounds / ADVANCE_ROUNDS % CONFIG_AXES;
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        const struct axis *axis = axes_get(i);
        uint8_t tail = step_timer_tail(i);
        // Without new entries there is nothing to account for.
        if (!is_urgent(axis, tail) &&
            (i != due || (tail == axis->feed.stream.retired &&
                          step_timer_state(i) == STEP_ENGINE_IN_LINE))) {
            continue;
        }
        (void)axes_advance(i, LEDGER_BY_WAYPOINTS);
    }
}

static APART bool awaited_may_be_over(uint8_t i)
{
    const struct stream *stream = &axes_get(i)->feed.stream;

    if (stream_train_free(stream)) {
        return false;
    }
    uint8_t tail = step_timer_tail(i);

    return tail != stream->retired && !stream_in_older_train(stream, tail);
}

// True when the account of an axis whose decoder waits for a train may find one over.
static inline bool train_may_be_over(uint8_t i)
{
    return axis_awaits_train(axes_get(i)) && awaited_may_be_over(i);
}

// Advance an account between two rounds' looks at the clock. An edge captured since holds up the
// account of the clock's axis, and is taken first. Returns false when the account stays for that.
static bool advance_now(uint8_t i)
{
    if (i == CONFIG_PIXEL_CLOCK_AXIS) {
        clock_edges_poll();
    }
    return axes_advance(i, LEDGER_BY_WAYPOINTS);
}

// Advance an account that waits for the end of a train. Returns false when it found nothing new: a
// single period before the train may take as long as some rounds.
static bool advance_moves(uint8_t i)
{
    const struct stream *stream = &axes_get(i)->feed.stream;
    uint8_t retired = stream->retired;

    // The account changes what is read-only here.
    // cppcheck-suppress knownConditionTrueFalse
    return advance_now(i) && (stream->retired != retired || stream_train_free(stream));
}

// Advance these accounts, right before the decoding. A pixel's edge ends the trains of all axes,
// and may come while one of them is looked at: look until there is nothing to do for any of them.
static void advance_ended_trains(void)
{
    uint8_t looks = 0;
    uint8_t calls = 2u * CONFIG_AXES; // an axis may be on its way to the older train

    for (uint8_t i = 0; looks < CONFIG_AXES && calls != 0; i = (i + 1u) % CONFIG_AXES) {
        looks++;
        if (train_may_be_over(i) && advance_moves(i)) {
            looks = 0;
            calls--;
        }
    }
}

// Read the switches of one axis after the other, each as often on every board.
static void poll_inputs(void)
{
    uint8_t axis = rounds % INPUT_ROUNDS;

    if (axis < CONFIG_AXES) {
        inputs_poll(CONFIG_INDEX(axis),
                    FEATURE_SHARED_SWITCH && seek_uses_switch(CONFIG_INDEX(axis)));
        drivers_poll(CONFIG_INDEX(axis));
        if (FEATURE_BACKLASH) {
            (void)ledger_settle_play(&axes_get(axis)->ledger);
        }
    }
    seek_poll();
}

// Decode for axis i. Returns what is left of the budget.
static inline uint8_t decode_one(uint8_t i, uint8_t budget)
{
    struct axis *axis = axes_get(i);

    // The place of a single axis is known.
    if (CONFIG_AXES > 1) {
        BY_POINTER(axis);
    }
    // An axis that waited for a train has one now: its account was advanced for that.
    if (CONFIG_AXES == 1 || !axis_awaits_train(axis)) {
        (void)axes_advance(i, LEDGER_BY_WAYPOINTS);
    }
#if CONFIG_AXES > 1
    if (axis->line.source.smooth) { // of others nobody asks
        axis->made_entries = (uint8_t)(step_timer_tail(i) - axis->feed.stream.retired);
    }
#endif
    cpu_section(axis->line.source.smooth ? CPU_SECTION_SMOOTH : CPU_SECTION_PLAIN);
    budget = decode_axis(axis, reference_pixel(), budget);
    cpu_section(CPU_SECTION_CALLER);
    return budget;
}

#if CONFIG_AXES == 1
static inline void decode_in_turn(uint8_t at_once, bool briefly)
{
    (void)briefly; // one call is short enough
    if (!decode_is_ahead(axes_get(0))) {
        (void)decode_one(0, at_once);
    }
}
#else
// True when the ring of an axis may look full only because its account lags: slots are free when
// they are accounted for, and the interrupt has made much of what stands there.
static inline bool account_lags(const struct axis *axis, uint8_t tail)
{
    const struct stream *stream = &axis->feed.stream;

    return (uint8_t)(tail - stream->retired) >= ADVANCE_ENTRIES;
}

// True when the decoder of a seek may go on: how far ahead it is, the account tells.
static inline bool seek_may_go_on(const struct axis *axis, uint8_t tail)
{
    return segment_source_ends_early(&axis->line.source) &&
           tail != axis->feed.stream.retired;
}

// True when what the decoder of an axis waits for, a train, room or time, may be over by now: the
// decoding for another axis can take as long as a pixel.
static bool wait_may_be_over(uint8_t i)
{
    const struct axis *axis = axes_get(i);
    uint8_t tail = step_timer_tail(i);

    return train_may_be_over(i) || account_lags(axis, tail) ||
           room_may_be_free(axis, tail) || seek_may_go_on(axis, tail);
}

// True when something can be decoded for axis i now.
static bool decodable(uint8_t i)
{
    if (!decode_is_ahead(axes_get(i))) {
        return true;
    }
    return wait_may_be_over(i) && advance_now(i) && !decode_is_ahead(axes_get(i));
}

// axis_bit() where nobody knows the axis beforehand: a shift by a variable is a loop.
_Static_assert(CONFIG_AXES <= 4, "two bits make an index");
static inline uint8_t bit_of(uint8_t axis)
{
    uint8_t bit = (uint8_t)((axis & 1u) != 0 ? 2u : 1u);

    return (uint8_t)((axis & 2u) != 0 ? bit << 2 : bit);
}

// The axis whose decoded entries end first, of those not in the mask `out`; NO_AXIS: it has them
// all. All axes share one time base, so that the end of the newest entry tells, however far each
// account lags.
static inline uint8_t first_of_others(uint8_t out)
{
    uint8_t found = NO_AXIS;
    uint32_t found_ticks = 0;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        uint32_t end_ticks = stream_end_ticks(&axes_get(i)->feed.stream);
        if ((out & axis_bit(i)) == 0 &&
            (found == NO_AXIS || (int32_t)(end_ticks - found_ticks) < 0)) {
            found = i;
            found_ticks = end_ticks;
        }
    }
    return found;
}

// The first of them for which something can be decoded; NO_AXIS: there is none.
static uint8_t first_to_end(uint8_t out)
{
    uint8_t i = first_of_others(out);

    while (i != NO_AXIS && !decodable(i)) {
        out |= bit_of(i);
        i = first_of_others(out);
    }
    return i;
}

// True when the bus brings entries of lines, and a line needs more of them.
static bool line_data_waits(void)
{
    bool needed = false;

    if (!bus_port_brings_data()) {
        return false;
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        needed = needed || axis_streams(axes_get(i));
    }
    return needed;
}

// True when a long turn must end before the next curve: an edge taken in it has placed lines, and
// their release comes soon.
static APART bool must_end(uint8_t at_once)
{
    return at_once > DECODE_AT_ONCE_STARTING && start_near();
}

static inline bool ends_before(const struct axis *axis, uint8_t at_once)
{
    return axis->line.source.smooth && must_end(at_once);
}

// Whether an axis has no part in what follows: it left all of what it was given, or a plain line
// left some.
static inline bool is_out(const struct axis *axis, uint8_t given, uint8_t left)
{
    return left == given || (left != 0 && !axis->line.source.smooth);
}

// Those of the axes that are out whose train is not over meanwhile.
static inline uint8_t still_out(uint8_t out)
{
    for (uint8_t i = 0; out != 0 && i < CONFIG_AXES; i++) {
        if ((out & axis_bit(i)) != 0 && train_may_be_over(i)) {
            out = (uint8_t)(out & ~axis_bit(i));
        }
    }
    return out;
}

static inline bool time_is_over(uint16_t since_units)
{
    return (uint16_t)((uint16_t)clock_now_units() - since_units) >=
           clock_units_of_us(DECODE_US);
}

// Decode for the axis that runs out first, and again for it until another axis would. An axis that
// must wait after all is out, and so is one of a plain line that has come to wait: whole pixels are
// decoded as far as there is room for them. One that waits for a train comes back when the train is
// over. The clock's edges are taken in between: at kilohertz as many as can wait come in one such
// round, and the accounts pass no pixel whose edge is not known yet. briefly: the bus waits.
static void decode_in_turn(uint8_t at_once, bool briefly)
{
    uint16_t since_units = (uint16_t)clock_now_units();
    uint8_t out = 0;
    uint8_t calls = 0;
    uint8_t left = at_once;

    do {
        if (calls >= DECODE_CALLS_LEAST && (briefly || line_data_waits())) {
            return;
        }
        clock_edges_poll();
        out = still_out(out);
        uint8_t i = first_to_end(out);
        if (i == NO_AXIS || ends_before(axes_get(i), at_once)) {
            return;
        }
        left = decode_one(i, at_once);
        if (is_out(axes_get(i), at_once, left)) {
            out |= bit_of(i);
        }
        calls++;
    } while (at_once == DECODE_AT_ONCE_STARTING ? left == at_once
                                                : !time_is_over(since_units));
}
#endif

// Only an axis that is about to start counts: a token or a driver may hold an axis back for long
// while others run. A single axis counts until it runs: the slow steps with which its ring is
// filled must leave time for the clock's edges, of which few can wait.
static bool starting(void)
{
    return CONFIG_AXES == 1 ? axes_get(0)->life.state != AXIS_RUNNING : start_near();
}

// briefly: in the middle of a request.
static APART void decode_some(bool briefly)
{
    decode_in_turn(starting() ? DECODE_AT_ONCE_STARTING : DECODE_AT_ONCE, briefly);
}

// The axis of the pixel clock cannot be released while an edge waits. At kilohertz a round brings
// such an edge nearly every time, and line zero does not wait.
static void release_lines(void)
{
    uint8_t tries = RELEASE_TRIES;

    do {
        if (starting()) {
            clock_edges_poll();
        }
        tries--;
    } while (!start_poll() && tries != 0);
}

// Everything but the decoding of steps. Apart from it, so that the stack of each of the two is free
// for the other.
static APART void look_after_axes(void)
{
    cpu_section(CPU_SECTION_ROUND);
    // Underruns come first: after an underrun the place of a clock edge is not known.
    take_underruns();
    clock_edges_poll();
    if (CONFIG_AXES == 1) {
        advance_in_turn();
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        supervise_axis(i);
    }
    // A single axis cannot lag: the waits of its interrupt add up to less than its shortest
    // interval.
    if (CONFIG_AXES > 1) {
        time_check_poll();
        parking_poll();
    }
    safety_poll();
    poll_inputs();
    release_lines();
    clock_edges_miss();
    store_poll();
    if (CONFIG_AXES > 1) {
        clock_edges_poll();
        advance_in_turn();
        advance_ended_trains();
    }
}

void round_poll(void)
{
    look_after_axes();
    decode_some(false);
    // Several axes take edges between two decodings (decode_in_turn()).
    if (CONFIG_AXES == 1) {
        clock_edges_poll();
    }
}

#if CONFIG_AXES > 1
// True when what is decoded for this axis lasts until then, or nothing more can be decoded. The
// interrupt needs the next entry when the last period begins.
static inline bool lasts_until(const struct axis *axis, uint32_t until_ticks)
{
    const struct stream *stream = &axis->feed.stream;

    return axis->phase == DECODE_OUTSIDE || axis->phase == DECODE_DRY ||
           (int32_t)(stream_end_ticks(stream) - stream_newest_ticks(stream) -
                     until_ticks) >= 0;
}

// True when no axis comes near the end of what is decoded for it before the next look.
static APART bool all_have_enough(void)
{
    uint32_t until_ticks = time_check_now_ticks() + ENOUGH_TICKS;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (!lasts_until(axes_get(i), until_ticks)) {
            return false;
        }
    }
    return true;
}

// What cannot wait for the end of a request: edges of the clock, a start, and rings that run low.
// Returns false when none runs low.
static APART bool look_briefly(void)
{
    cpu_section(CPU_SECTION_INTERLUDE);
    take_underruns();
    clock_edges_poll();
    if (starting()) {
        release_lines();
    } else if (all_have_enough()) {
        return false;
    }
    advance_in_turn();
    advance_ended_trains();
    return true;
}

void round_poll_briefly(void)
{
    if (!look_briefly()) {
        return;
    }
    decode_some(true);
}
#endif
