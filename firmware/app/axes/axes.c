// SPDX-License-Identifier: MIT
#include "app/axes/axes.h"

#include "app/axes/token.h"    // token_set
#include "base/apart.h"        // APART
#include "hal/cpu.h"           // cpu_section
#include "hal/pixel_clock.h"   // pixel_clock_waiting
#include "hal/step_timer.h"    // step_timer_*
#include "hal/switches.h"      // switch_capture_waiting
#include "steps/train_pixel.h" // TRAIN_STAGGER_MAX

// All axes cross a pixel edge at the same time. A step interrupt takes longer to begin a pulse
// train than to continue one, so that the axes begin their trains some steps apart.
#define TRAIN_STAGGER_STEPS 2u
_Static_assert(TRAIN_STAGGER_STEPS *(CONFIG_AXES - 1u) <= TRAIN_STAGGER_MAX,
               "known to train_pixel.c");

static struct axis axes[CONFIG_AXES];
static uint8_t queue_bytes[CONFIG_AXES][CONFIG_QUEUE_BYTES];

void axes_start(void)
{
#if FEATURE_LINE_ENDS
    axis_company(axes, CONFIG_AXES);
#endif
    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        const struct axis_parts parts = {
            .ring = step_timer_ring(i),
            .trains = step_timer_trains(i),
            .queue_bytes = queue_bytes[i],
            .queue_size = CONFIG_QUEUE_BYTES,
            .stagger = (uint8_t)(TRAIN_STAGGER_STEPS * i),
            .first_period_ticks = STEP_IDLE_TICKS,
        };
        struct axis *axis = axes_get(i);
        BY_POINTER(axis);
        axis_init(axis, &parts);
    }
}

struct axis *axes_get(uint8_t axis)
{
    return &axes[CONFIG_INDEX(axis)];
}

uint8_t axes_first_moving(void)
{
    uint8_t i = 0;

    while (i < CONFIG_AXES && !lifecycle_moving(&axes[i].life)) {
        i++;
    }
    return i;
}

bool axes_any_armed(void)
{
    uint8_t i = 0;

    while (i < CONFIG_AXES && !lifecycle_armed(&axes[i].life)) {
        i++;
    }
    return i < CONFIG_AXES;
}

#if SEVERAL_AXES
bool axes_any_running(void)
{
    uint8_t i = 0;

    while (i < CONFIG_AXES && axes[i].life.state != AXIS_RUNNING) {
        i++;
    }
    return i < CONFIG_AXES;
}
#endif

bool axes_any_queued(void)
{
    bool queued = axes_first_moving() != NO_AXIS;

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        queued = queued ||
                 segment_queue_fill(&axes[i].queue) > LINE_HEAD_ENTRIES * SEGMENT_MOST;
    }
    return queued;
}

// True when an edge was captured that needs a sample of this axis. The account must come to that
// sample before it follows a newer one. A single axis has one capture for both inputs.
static bool capture_waits(uint8_t i)
{
    return (CONFIG_INDEX(i) == CONFIG_PIXEL_CLOCK_AXIS && pixel_clock_waiting()) ||
           (FEATURE_HOMING && CONFIG_AXES > 1 && switch_capture_waiting());
}

// Not inline: the sample and the account's own registers are off the stack again when the caller
// goes on.
static APART bool advance(uint8_t i, enum ledger_extent extent, bool rested)
{
    struct axis *axis = axes_get(i);
    struct engine_sample sample;

    step_timer_sample(i, &sample);
    if (!rested && capture_waits(i)) {
        return false;
    }
    // A single axis has little to ask, and asking takes as long.
    if (CONFIG_AXES == 1 || extent == LEDGER_EXACTLY ||
        ledger_due(&axis->ledger, &axis->feed.stream, &sample)) {
        cpu_section(CPU_SECTION_LEDGER);
        ledger_advance(&axis->ledger, &axis->feed.stream, &sample, extent);
        cpu_section(CPU_SECTION_CALLER);
    }
    return true;
}

#if CONFIG_AXES > 1
bool axes_time_at(uint8_t i,
                  const struct engine_sample *sample,
                  uint16_t counter,
                  uint32_t *ticks)
{
    struct axis *axis = axes_get(i);

    if (capture_waits(i)) {
        return false;
    }
    cpu_section(CPU_SECTION_LEDGER);
    *ticks =
        ledger_advance_to_capture(&axis->ledger, &axis->feed.stream, sample, 1, counter);
    cpu_section(CPU_SECTION_CALLER);
    return true;
}
#endif

bool axes_sample(uint8_t i, struct engine_sample *sample)
{
    struct axis *axis = axes_get(i);

    step_timer_sample(i, sample);
    if (capture_waits(i)) {
        return false;
    }
    cpu_section(CPU_SECTION_LEDGER);
    ledger_advance(&axis->ledger, &axis->feed.stream, sample, LEDGER_BY_WAYPOINTS);
    cpu_section(CPU_SECTION_CALLER);
    return true;
}

bool axes_advance_at(uint8_t i, enum ledger_extent extent)
{
    struct axis *axis = axes_get(i);

    // How far ahead a seek is decoded, the account tells: it must not wait for the waypoint that
    // comes with the next pixel.
    if (CONFIG_AXES > 1 && segment_source_ends_early(&axis->line.source) &&
        stream_is_open(&axis->feed.stream)) {
        extent = LEDGER_EXACTLY;
    }
    // Single periods are nearly all there is, and need no sample.
    if (CONFIG_AXES > 1 && extent == LEDGER_BY_WAYPOINTS) {
        uint8_t tail = step_timer_tail(i);

        if (capture_waits(i)) {
            return false;
        }
        if (ledger_advance_plain(&axis->ledger, &axis->feed.stream, tail)) {
            return true;
        }
    }
    return advance(i, extent, false);
}

void axes_advance_rested(uint8_t i)
{
    (void)advance(CONFIG_INDEX(i), LEDGER_EXACTLY, true);
}

// Rounds that a stopping axis waits for clock edges to be taken. Noise must not hold it for good.
#define EDGE_ROUNDS 8u

// Bring the account of a stopping axis at rest up to now, before its lines are discarded. Returns
// false while a captured edge must be placed by the account as it is: the next round takes it.
static bool advance_to_rest(uint8_t i)
{
    static uint8_t waited;

    if (!advance(i, LEDGER_EXACTLY, waited == EDGE_ROUNDS)) {
        waited++;
        return false;
    }
    waited = 0;
    return true;
}

void axes_stop_at(uint8_t i)
{
    struct axis *axis = axes_get(i);
    uint8_t slot = 0;

    axis_stop(axis);
    if (CONFIG_AXES == 1 || !axes_any_armed()) {
        token_set(0);
    }
    if (!step_engine_going(step_timer_state(i))) {
        if (!advance_to_rest(i)) {
            return;
        }
        if (step_timer_settle(i, &slot)) {
            axis_discard(axis, slot);
            return;
        }
    }
    step_timer_halt(i);
}
