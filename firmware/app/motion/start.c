// SPDX-License-Identifier: MIT
#include "app/motion/start.h"

#include "app/axes/axes.h"         // axes_*
#include "app/axes/faults.h"       // faults_latch
#include "app/axes/gate.h"         // gate_*
#include "app/axes/mark.h"         // mark_*
#include "app/axes/reference.h"    // reference_*
#include "app/axes/token.h"        // token_*
#include "app/settings/settings.h" // settings_now
#include "app/watch/drivers.h"     // drivers_settling
#include "app/watch/time_check.h"  // time_check_now_ticks
#include "app/watch/witness.h"     // witness_excuse
#include "axis/decode.h"           // decode_is_ahead
#include "base/apart.h"            // BY_POINTER
#include "clock/lock_grid.h"       // lock_grid_*
#include "hal/step_timer.h"        // step_timer_*

// Room that line zero leaves the main loop to come by and release the line: a reply being built
// takes a good two milliseconds.
#define START_MIN_TICKS ((int32_t)60000)
// Release as soon as the delay fits, with a margin.
#define RELEASE_MAX_TICKS ((int32_t)120000)
// By so much a clock that is not asked for the account may be ahead of it.
#define FAR_TICKS ((int32_t)0x20000)
// The delay is two periods; the second covers the direction set-up time, and neither may be too
// short for the commands before it.
#define COMMANDS_TICKS 1000u

static int32_t release_min_ticks(void)
{
    uint16_t setup_ticks = (uint16_t)(settings_now()->dir_setup_us *
                                      (uint16_t)(CONFIG_TIMER_HZ / 1000000uL));

    return (uint16_t)(2u * (setup_ticks + COMMANDS_TICKS));
}

// Ticks from the newest loaded period to the first period of the line.
static APART int32_t ticks_to_start(const struct axis *axis, uint32_t zero_ticks)
{
    return (int32_t)(zero_ticks - STEP_TIMER_EDGE_TICKS + axis->feed.lead_in_ticks -
                     axis->ledger.loaded_ticks);
}

// The axis waits for a clock edge; an armed axis that needs none is STARTING already.
static bool waits_for_edge(uint8_t i)
{
    return axes_get(i)->life.state == AXIS_ARMED;
}

static bool clocked_axis_in(uint8_t state)
{
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        const struct axis *axis = axes_get(i);
        if (axis->life.state == state && axis->clocked) {
            return true;
        }
    }
    return false;
}

bool start_clocked_axis_runs(void)
{
    return clocked_axis_in(AXIS_RUNNING);
}

#if CONFIG_AXES > 1
bool start_clocked_axis_begun(void)
{
    return clocked_axis_in(AXIS_STARTING) || start_clocked_axis_runs();
}
#endif

// True when the clock's edges are counted for other lines already. Locked ones count from the
// moment on when their line zero is known: lock_grid_begin() would forget that. When a gate names
// line zero, the lines of all axes that run are over.
static bool beside_others(void)
{
    return CONFIG_AXES > 1 && !token_edge_by_gate() &&
           (start_clocked_axis_runs() ||
            (lock_grid_now()->locks && clocked_axis_in(AXIS_STARTING)));
}

// Armed axes must wait for command `go`, or for a driver that was switched on lately.
static APART bool held_back(void)
{
    return token_held() || drivers_settling();
}

// The slow first steps of a line take the most decoding, and only an axis at rest has the time for
// it: the ring is filled before line zero.
bool start_ready(void)
{
    if (drivers_settling() || (lock_grid_now()->locks && !reference_settled())) {
        return false;
    }
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (waits_for_edge(i) && !decode_is_ahead(axes_get(i))) {
            return false;
        }
    }
    return true;
}

bool start_any_waits(void)
{
    bool waits = false;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        waits = waits || waits_for_edge(i);
    }
    return waits;
}

// Give every waiting axis this line zero, pixel edge `number`. Returns how many pixel edges the
// line that was decoded furthest has behind it.
static uint16_t place_all(uint16_t number, uint32_t zero)
{
    uint16_t most = 0;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (waits_for_edge(i)) {
            struct axis *axis = axes_get(i);
            axis_place(axis, zero);
            if (line_grid_locked(&axis->line.edges)) {
                line_grid_place(&axis->line.edges, number, zero);
            }
            uint16_t decoded = line_grid_decoded(&axis->line.edges, number);
            most = decoded > most ? decoded : most;
        }
    }
    return most;
}

#if FEATURE_CLOCK_STATISTICS
static uint8_t followers;

uint8_t start_followers(void)
{
    return followers;
}

static void note_followers(void)
{
    uint32_t zero_ticks = reference_watch()->zero_ticks;

    followers = 0;
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        if (axes_get(i)->zero_ticks == zero_ticks) {
            followers |= axis_bit(i);
        }
    }
}
#else
static void note_followers(void)
{
}
#endif

// What starts lines saves many registers, and most edges start none.
#if SEVERAL_AXES
#define LINES_APART APART
#else
#define LINES_APART inline
#endif

#if CONFIG_AXES > 1
// Locked lines run: the number of their first pixel edge from this clock edge on, which becomes the
// clock edge that it is.
static uint16_t pixel_edge_from(uint16_t *edge)
{
    const struct lock_grid *grid = lock_grid_now();

    while ((int16_t)(grid->newest_edge - *edge) < 0) {
        (void)lock_grid_next();
    }
    uint16_t number = grid->newest;
    uint16_t at = grid->newest_edge;

    while ((int16_t)(at - grid->divider - *edge) >= 0) {
        at = (uint16_t)(at - grid->divider);
        number--;
    }
    *edge = at;
    return number;
}
#endif

#if FEATURE_TOKENS && CONFIG_AXES > 1
// A line can begin on this clock edge: no other lines are locked to the clock, or it is a pixel
// edge of theirs.
static bool is_pixel_edge(uint16_t edge)
{
    uint16_t at = edge;

    if (lock_grid_now()->locks && beside_others()) {
        (void)pixel_edge_from(&at);
    }
    return at == edge;
}
#else
static inline bool is_pixel_edge(uint16_t edge)
{
    (void)edge;
    return true;
}
#endif

// The time of the edge that comes so many edges behind this one, by the plan, or by the grid of
// lines that are locked: it begins there.
static inline uint32_t time_ahead(uint32_t edge_ticks, uint16_t edges)
{
    struct pixel_grid plan;

    if (lock_grid_now()->locks) {
        return lock_grid_begin(edges);
    }
    pixel_grid_start(&plan, reference_period());
    for (; edges != 0; edges--) {
        edge_ticks += pixel_grid_advance(&plan);
    }
    return edge_ticks;
}

// Every waiting line begins with a pixel that begins so many clock edges behind this one. A line
// that is locked beside others begins on a pixel edge of theirs: the next one.
static LINES_APART void start_lines(uint32_t edge_ticks, uint16_t edges)
{
    bool beside = beside_others();
    uint16_t edge = (uint16_t)(reference_number() + edges);
    uint16_t number = 0;
    uint32_t zero = 0;

#if CONFIG_AXES > 1
    if (beside && lock_grid_now()->locks) {
        number = pixel_edge_from(&edge);
        zero = lock_grid_time(number);
    } else
#endif
    {
        zero = time_ahead(edge_ticks, edges);
    }
    mark_zero(edge);
    uint16_t decoded = place_all(number, zero);

    // One line is the clock's reference; a later start does not take that away from it.
    if (!beside) {
        // Lines that begin together end all pixels together, also those that only some of them have
        // decoded.
        if (CONFIG_AXES > 1) {
            lock_grid_keep(decoded, zero);
        }
        reference_follow(zero);
    }
    note_followers();
}

#if FEATURE_TOKENS
void start_go(uint16_t edge)
{
    token_set(0);
    if (start_any_waits()) {
        token_name_edge(edge);
    }
    reference_await_edge();
}
#endif

bool start_may_wait(void)
{
    return (token_held() || token_edge_named()) && !start_clocked_axis_begun();
}

// Lines can begin on the edge that is named, so many edges ahead.
static inline bool can_begin(int16_t ahead)
{
    return ahead > 0 && start_ready() && is_pixel_edge(token_edge()) && !gate_overruns();
}

void start_on_edge(uint32_t edge_ticks)
{
    uint16_t edges = reference_place_edges();

    if (token_edge_named()) {
        uint16_t ahead = (uint16_t)(token_edge() - reference_number());

        if ((int16_t)ahead > (int16_t)edges) {
            return;
        }
        edges = ahead;
        if (!can_begin((int16_t)ahead)) {
            faults_latch_plain(FAULT_start_late, axes_first_moving());
            return;
        }
    } else if (gate_on() || held_back() || !start_ready()) {
        return;
    }
    start_lines(edge_ticks, edges);
    if (gate_on()) {
        token_set(0); // the next burst may name an edge
    }
}

void start_now(uint8_t axis)
{
    axis_place(axes_get(axis), 0);
    note_followers();
}

// True when a line that needs no clock edge may begin. With several axes it waits for its ring to
// be full, too: what it makes from then on is decoded beside the starts of the others.
static inline bool may_begin(const struct axis *axis)
{
    return !held_back() && (CONFIG_AXES == 1 || decode_is_ahead(axis));
}

// A STARTING axis may be released. An axis that follows the clock has its line zero already, so
// that nothing holds it back.
static inline bool may_release(const struct axis *axis)
{
    return axis->life.state == AXIS_STARTING && (axis->clocked || may_begin(axis));
}

#if CONFIG_AXES > 1
bool start_near(void)
{
    const struct axis *axis = axes_get(0);

    for (uint8_t left = CONFIG_AXES; left != 0; left--) {
        if (may_release(axis)) {
            return true;
        }
        axis++;
    }
    return false;
}
#endif

// Ticks until the line of a STARTING axis begins. A line that does not follow the clock begins as
// soon as can be.
static inline int32_t delay_of(struct axis *axis)
{
    BY_POINTER_SMALL(axis);
    if (!axis->clocked) {
        axis->zero_ticks = (uint32_t)(2 * START_MIN_TICKS - ticks_to_start(axis, 0));
    }
    return ticks_to_start(axis, axis->zero_ticks);
}

enum release {
    // Released, or there is time for it in a later round.
    RELEASE_DONE,
    // An idle period began meanwhile: the next attempt has a whole idle period.
    RELEASE_AGAIN,
    // A captured edge waits, which has to be taken first.
    RELEASE_EDGE,
};

// True when the line of an axis begins so late that a round to come releases it, whatever its
// account says: that lags by two idle periods at most. Asks no account: with several axes, rounds
// and long requests try all of them, and a line may wait for seconds.
static inline bool is_far(const struct axis *axis)
{
    return CONFIG_AXES > 1 && axis->clocked &&
           (int32_t)(axis->zero_ticks - time_check_now_ticks()) >
               RELEASE_MAX_TICKS + FAR_TICKS;
}

static APART enum release release_line(uint8_t i)
{
    struct axis *axis = axes_get(i);
    struct feed *feed = &axis->feed;

    BY_POINTER(feed);
    if (!axes_advance(i, LEDGER_EXACTLY)) {
        return RELEASE_EDGE;
    }
    // The line's first interval can be merged into the delay only as long as that is not released.
    if (axis->phase != DECODE_OUTSIDE && feed->merge) {
        return RELEASE_DONE;
    }
    int32_t delay = delay_of(axis);

    if (delay > RELEASE_MAX_TICKS) {
        return RELEASE_DONE;
    }
    if (delay < release_min_ticks()) {
        faults_latch_plain(FAULT_start_late, i);
        return RELEASE_DONE;
    }
    // The next round's fault tells why the axis was halted.
    if (CONFIG_AXES > 1 && !step_timer_unpark(i)) {
        return RELEASE_DONE;
    }
    feed_fill_front(feed, (uint32_t)delay);
    if (!step_timer_publish(i, feed->held_slot, axis->ledger.idle_seen)) {
        return RELEASE_AGAIN;
    }
    feed_front_released(feed, (uint32_t)delay);
    if (axis_released(axis)) {
        witness_excuse(i);
    } else {
        // A promise was broken on the way: a fault, and nothing may run.
        step_timer_halt(i);
    }
    return RELEASE_DONE;
}

bool start_poll(void)
{
    uint8_t left = CONFIG_AXES;
    bool taken = true;

    if (CONFIG_AXES > 1 && !start_near()) {
        return true;
    }
    // Try again at once: a round as long as an idle period would meet the period's end every time.
    // The axis of the pixel clock, the last one of a board, comes first: it cannot be released
    // while an edge waits, and the next one comes soon.
    while (left != 0) {
        uint8_t i = (uint8_t)(left - 1u);
        enum release result = RELEASE_DONE;
        if (may_release(axes_get(i)) && !is_far(axes_get(i))) {
            result = release_line(CONFIG_INDEX(i));
        }
        if (result != RELEASE_AGAIN) {
            left--;
        }
        if (result == RELEASE_EDGE) {
            taken = false;
        }
    }
    return taken;
}
