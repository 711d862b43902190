// SPDX-License-Identifier: MIT
// The contents of the input registers. They come from tables in flash, because a function with a
// case for each register would take three times the room.
#include "app/registers/report.h"

#include <stddef.h> // offsetof

#include "app/axes/axes.h"         // axes_*
#include "app/axes/faults.h"       // faults_record
#include "app/axes/limits.h"       // limits_now
#include "app/axes/mark.h"         // mark_now
#include "app/axes/permit.h"       // permit_is_on
#include "app/axes/reference.h"    // reference_*
#include "app/bus/traffic.h"       // traffic_counters
#include "app/motion/seek.h"       // seek_now
#include "app/motion/start.h"      // start_*
#include "app/settings/settings.h" // settings_now
#include "app/settings/store.h"    // store_state
#include "app/watch/drivers.h"     // drivers_on
#include "app/watch/inputs.h"      // inputs_all
#include "base/flash.h"            // IN_FLASH
#include "base/interlude.h"        // interlude
#include "clock/lock_grid.h"       // lock_grid_now
#include "hal/cpu.h"               // cpu_reset_cause
#include "hal/estop.h"             // estop_tripped
#include "wire/bytes.h"            // half_word
#include "wire/register_map.h"     // REG_*

#define OUTPUTS_PERMIT 0x0100u

static inline uint16_t clock_status(void)
{
    uint16_t bits = reference_present() ? REPORT_CLOCK : 0;

    if (reference_settled()) {
        bits |= REPORT_SETTLED;
    }
    return bits;
}

uint16_t report_status(void)
{
    uint16_t bits = clock_status();

    for (uint8_t i = 0; i < CONFIG_AXES; i++) {
        const struct lifecycle *life = &axes_get(i)->life;
        if (lifecycle_armed(life)) {
            bits |= REPORT_ARMED;
        } else if (life->state == AXIS_RUNNING) {
            bits |= REPORT_RUNNING;
        } else if (life->state == AXIS_STOPPING) {
            bits |= (uint16_t)(REPORT_STOPPING << i);
        }
        if (axes_get(i)->play_unknown) {
            bits |= (uint16_t)(REPORT_PLAY << i);
        }
    }
    if (faults_any()) {
        bits |= REPORT_FAULT;
    }
    if (estop_tripped()) {
        bits |= REPORT_ESTOP;
    }
    if (server_listens_only(traffic_counters())) {
        bits |= REPORT_LISTEN_ONLY;
    }
    return permit_is_on() ? (uint16_t)(bits | REPORT_PERMIT) : bits;
}

static uint16_t status_word(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return report_status();
}

static uint16_t reset_cause_word(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return cpu_reset_cause();
}

static uint16_t inputs_word(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return inputs_all();
}

static uint16_t outputs_word(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return (uint16_t)(drivers_on() | (permit_is_on() ? OUTPUTS_PERMIT : 0));
}

static uint16_t ready_word(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return start_any_waits() && start_ready() ? 1u : 0;
}

static uint16_t clock_edge_word(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return reference_number();
}

static uint16_t settings_state_word(uint8_t axis, bool low)
{
    (void)axis;
    (void)low;
    return store_state();
}

static uint16_t queue_free(uint8_t axis, bool low)
{
    (void)low;
    return segment_queue_free_entries(&axes_get(axis)->queue);
}

static uint16_t ring_fill(uint8_t axis, bool low)
{
    (void)low;
    return axis_ring_fill(axes_get(axis));
}

// The position at the instant when its first word is read; the second word belongs to that
// position. Where there are several axes the account stays at a waypoint, which is cheaper: a host
// that follows a line reads all positions, and often.
static uint16_t position_steps(uint8_t axis, bool low)
{
    static int32_t shown_steps;
    static uint8_t shown_axis = NO_AXIS;
    struct axis *of = axes_get(axis);

    if (CONFIG_AXES == 1) {
        if (!low) {
            (void)axes_advance(axis, LEDGER_EXACTLY);
        }
        return half_word((uint32_t)ledger_position(&of->ledger), low);
    }
    if (!low || shown_axis != axis) {
        struct engine_sample sample;
        (void)axes_sample(axis, &sample);
        shown_steps = ledger_position_at(&of->ledger, &of->feed.stream, sample.tail);
    }
    shown_axis = low ? NO_AXIS : axis;
    return half_word((uint32_t)shown_steps, low);
}

static uint16_t expected_steps(uint8_t axis, bool low)
{
    const struct records *records = &axes_get(axis)->ledger.records;

    if (records->count == 0) {
        return 0;
    }
    // Words 1 and 2 of a record hold the expected position.
    return records_word(records, (uint8_t)(records->count - 1u), low ? 2 : 1);
}

static uint16_t axis_state(uint8_t axis, bool low)
{
    (void)low;
    return lifecycle_shown(&axes_get(axis)->life);
}

// The module with the object whose member a register shows.
enum owner {
    OWNER_FAULTS,
    OWNER_WATCH,
    OWNER_SEEK,
    OWNER_SETTINGS,
    OWNER_TRAFFIC,
    OWNER_AXIS,
    OWNER_GRID,
    OWNER_MARK,
};

// The lowest bits of a member's kind are its owner.
#define OWNER_MASK 0x07u

enum width {
    WIDTH_BYTE = 0x08,
    WIDTH_WORD = 0x10,
    WIDTH_HIGH = 0x18, // high word of a member of 32 bits
    WIDTH_LOW = 0x20,  // low word of a member of 32 bits
};

enum call {
    KIND_CONSTANT,
    KIND_CALL_HIGH,
    KIND_CALL_LOW,
};

// Where a register's word comes from: a constant, a function's result or a member of an object. For
// a member, kind is its width plus its owner, and value is its offset in the owner's object.
struct source {
    union {
        uint16_t value;
        uint16_t (*call)(uint8_t axis, bool low);
    };
    uint8_t kind; // enum call, or enum width + enum owner
};

#define CONSTANT(number) {.value = (number), .kind = KIND_CONSTANT}
#define CALL(function)   {.call = (function), .kind = KIND_CALL_LOW}
#define MEMBER(width, owner, place)                                                      \
    {.value = (uint16_t)(place), .kind = (uint8_t)((uint8_t)(width) + (uint8_t)(owner))}
#define LONG(first, owner, place)                                                        \
    [first] = MEMBER(WIDTH_HIGH, owner, place),                                          \
    [(first) + 1] = MEMBER(WIDTH_LOW, owner, place)
#define CALL_LONG(first, function)                                                       \
    [first] = {.call = (function), .kind = KIND_CALL_HIGH},                              \
    [(first) + 1] = {.call = (function), .kind = KIND_CALL_LOW}
#define IN_FAULTS(member) offsetof(struct fault_record, member)
#define IN_WATCH(member)  offsetof(struct clock_watch, member)
#define IN_FILTER(member) offsetof(struct lock_grid, filter.member)
#define IN_MARK(member)   offsetof(struct mark, member)
#define IN_SEEK(member)   offsetof(struct seek, member)
#define IN_AXIS(member)   offsetof(struct axis, member)
#define COUNTER(name)                                                                    \
    MEMBER(WIDTH_WORD, OWNER_TRAFFIC, offsetof(struct server_counters, name))

#define MORE_BASE     REG_INPUT_fault_mask_high
#define MORE_PLACE    (REG_AXIS_BASE + REG_AXIS_STRIDE)
#define AXIS(offset)  (REG_AXIS_BASE + (offset))
#define MORE(address) (MORE_PLACE + (address) - MORE_BASE)
#define SOURCES       MORE(REG_INPUT_features_high + 1)

// The board's registers, those of one axis for all of them, and the board's others.
static const struct source sources[SOURCES] IN_FLASH = {
    [REG_INPUT_map_version] = CONSTANT(REG_MAP_VERSION),
    [REG_INPUT_firmware_version] =
        CONSTANT(CONFIG_VERSION_MAJOR * 256u + CONFIG_VERSION_MINOR),
    [REG_INPUT_board_id] = CONSTANT(CONFIG_BOARD_ID),
    [REG_INPUT_axis_count] = CONSTANT(CONFIG_AXES),
    [REG_INPUT_status] = CALL(status_word),
    [REG_INPUT_fault_code] = MEMBER(WIDTH_BYTE, OWNER_FAULTS, IN_FAULTS(code)),
    [REG_INPUT_fault_argument] = MEMBER(WIDTH_WORD, OWNER_FAULTS, IN_FAULTS(argument)),
    [REG_INPUT_fault_axis] = MEMBER(WIDTH_BYTE, OWNER_FAULTS, IN_FAULTS(axis)),
    LONG(REG_INPUT_fault_pixel, OWNER_FAULTS, IN_FAULTS(pixel)),
    [REG_INPUT_fault_mask] = MEMBER(WIDTH_LOW, OWNER_FAULTS, IN_FAULTS(mask)),
    [REG_INPUT_reset_cause] = CALL(reset_cause_word),
    LONG(REG_INPUT_pixel_edges, OWNER_WATCH, IN_WATCH(edges)),
#if FEATURE_CLOCK_STATISTICS
    [REG_INPUT_edge_error_ticks] = MEMBER(WIDTH_WORD, OWNER_WATCH, IN_WATCH(error_ticks)),
    [REG_INPUT_edge_error_max_ticks] =
        MEMBER(WIDTH_WORD, OWNER_WATCH, IN_WATCH(error_max_ticks)),
#endif
    [REG_INPUT_frames_ok] = COUNTER(frames_ok),
    [REG_INPUT_crc_errors] = COUNTER(crc_errors),
    [REG_INPUT_exceptions] = COUNTER(exceptions),
    [REG_INPUT_rx_overruns] = COUNTER(rx_overruns),
    LONG(REG_INPUT_pixel_period_ticks,
         OWNER_GRID,
         offsetof(struct lock_grid, pixel.whole_ticks)),
    [REG_INPUT_min_interval_ticks] = CONSTANT(CONFIG_MIN_INTERVAL_TICKS),
    [REG_INPUT_smooth_min_interval_ticks] = CONSTANT(CONFIG_SMOOTH_MIN_INTERVAL_TICKS),
    [REG_INPUT_record_capacity] = CONSTANT(RECORDS_KEPT),
    [REG_INPUT_inputs] = CALL(inputs_word),
#if FEATURE_HOMING
    [REG_INPUT_trip_code] = MEMBER(WIDTH_BYTE, OWNER_SEEK, IN_SEEK(trip_code)),
    [REG_INPUT_trip_axis] = MEMBER(WIDTH_BYTE, OWNER_SEEK, IN_SEEK(trip_axis)),
    LONG(REG_INPUT_trip_position_steps, OWNER_SEEK, IN_SEEK(position_steps)),
    LONG(REG_INPUT_trip_ticks, OWNER_SEEK, IN_SEEK(ticks)),
#else
    [REG_INPUT_trip_ticks + 1] = CONSTANT(0),
#endif

    [AXIS(REG_AXIS_axis_state)] = CALL(axis_state),
    [AXIS(REG_AXIS_queue_free)] = CALL(queue_free),
    [AXIS(REG_AXIS_next_block)] = MEMBER(WIDTH_WORD, OWNER_AXIS, IN_AXIS(next_block)),
    [AXIS(REG_AXIS_line_error)] = MEMBER(WIDTH_BYTE, OWNER_AXIS, IN_AXIS(line_error)),
    LONG(AXIS(REG_AXIS_line_error_pixel), OWNER_AXIS, IN_AXIS(line_error_pixel)),
    CALL_LONG(AXIS(REG_AXIS_position_steps), position_steps),
    CALL_LONG(AXIS(REG_AXIS_expected_steps), expected_steps),
    LONG(AXIS(REG_AXIS_pixel), OWNER_AXIS, IN_AXIS(ledger.pixel)),
    [AXIS(REG_AXIS_lines_done)] =
        MEMBER(WIDTH_WORD, OWNER_AXIS, IN_AXIS(ledger.lines_done)),
    [AXIS(REG_AXIS_underruns)] = MEMBER(WIDTH_WORD, OWNER_AXIS, IN_AXIS(underruns)),
    [AXIS(REG_AXIS_line_warning)] = MEMBER(WIDTH_BYTE, OWNER_AXIS, IN_AXIS(line_warning)),
    [AXIS(REG_AXIS_ring_fill)] = CALL(ring_fill),

    [MORE(REG_INPUT_fault_mask_high)] = MEMBER(WIDTH_HIGH, OWNER_FAULTS, IN_FAULTS(mask)),
    [MORE(REG_INPUT_outputs)] = CALL(outputs_word),
    [MORE(REG_INPUT_settings_state)] = CALL(settings_state_word),
    [MORE(REG_INPUT_settings_serial)] =
        MEMBER(WIDTH_WORD, OWNER_SETTINGS, offsetof(struct settings, serial)),
    [MORE(REG_INPUT_bus_messages)] = COUNTER(bus_messages),
    [MORE(REG_INPUT_no_replies)] = COUNTER(no_replies),
    [MORE(REG_INPUT_busy_replies)] = COUNTER(busy_replies),
    [MORE(REG_INPUT_event_capacity)] = CONSTANT(FEATURE_EVENTS ? CONFIG_EVENTS : 0),
    [MORE(REG_INPUT_features)] = CONSTANT(FEATURES_BITS),
    [MORE(REG_INPUT_min_interval_1_ticks)] = CONSTANT(BOARD_MIN_INTERVAL_1_TICKS),
    [MORE(REG_INPUT_min_interval_2_ticks)] = CONSTANT(BOARD_MIN_INTERVAL_2_TICKS),
    [MORE(REG_INPUT_min_interval_3_ticks)] = CONSTANT(BOARD_MIN_INTERVAL_3_TICKS),
    [MORE(REG_INPUT_smooth_min_interval_1_ticks)] =
        CONSTANT(BOARD_SMOOTH_MIN_INTERVAL_1_TICKS),
    [MORE(REG_INPUT_smooth_min_interval_2_ticks)] =
        CONSTANT(BOARD_SMOOTH_MIN_INTERVAL_2_TICKS),
    [MORE(REG_INPUT_smooth_min_interval_3_ticks)] =
        CONSTANT(BOARD_SMOOTH_MIN_INTERVAL_3_TICKS),
    LONG(MORE(REG_INPUT_clock_period_ticks),
         OWNER_GRID,
         IN_FILTER(period) + offsetof(struct fine_ticks, ticks)),
    [MORE(REG_INPUT_clock_period_fraction)] =
        MEMBER(WIDTH_WORD,
               OWNER_GRID,
               IN_FILTER(period) + offsetof(struct fine_ticks, fraction)),
    [MORE(REG_INPUT_clock_jitter)] = MEMBER(WIDTH_WORD, OWNER_GRID, IN_FILTER(jitter)),
    [MORE(REG_INPUT_clock_glitches)] =
        MEMBER(WIDTH_WORD, OWNER_GRID, IN_FILTER(glitches)),
    [MORE(REG_INPUT_clock_missing)] = MEMBER(WIDTH_WORD, OWNER_GRID, IN_FILTER(missing)),
    LONG(MORE(REG_INPUT_clock_error_ticks), OWNER_GRID, IN_FILTER(error_ticks)),
    [MORE(REG_INPUT_clock_interval)] = MEMBER(WIDTH_WORD, OWNER_WATCH, IN_WATCH(odd)),
#if FEATURE_TOKENS
    LONG(MORE(REG_INPUT_mark_units), OWNER_MARK, IN_MARK(units)),
    LONG(MORE(REG_INPUT_started_units), OWNER_MARK, IN_MARK(started_units)),
    [MORE(REG_INPUT_mark_count)] = MEMBER(WIDTH_BYTE, OWNER_MARK, IN_MARK(count)),
    [MORE(REG_INPUT_mark_steady)] = MEMBER(WIDTH_BYTE, OWNER_MARK, IN_MARK(steady)),
    [MORE(REG_INPUT_zero_edge)] = MEMBER(WIDTH_WORD, OWNER_MARK, IN_MARK(zero_edge)),
#endif
    [MORE(REG_INPUT_ready)] = CALL(ready_word),
    [MORE(REG_INPUT_clock_edge)] = CALL(clock_edge_word),
    LONG(MORE(REG_INPUT_clock_edge_ticks), OWNER_WATCH, IN_WATCH(edge_ticks)),
    LONG(MORE(REG_INPUT_clock_expected_ticks),
         OWNER_GRID,
         IN_FILTER(expected) + offsetof(struct fine_ticks, ticks)),
    [MORE(REG_INPUT_features_high)] = CONSTANT(FEATURES_HIGH_BITS),
};

_Static_assert(AXIS(0) == REG_INPUT_trip_ticks + 2,
               "the board's registers end where the axes' begin");
_Static_assert(SOURCES <= UINT8_MAX, "a byte is a place");

// The word of a member. width: enum width.
static inline uint16_t word_at(const void *at, uint8_t width)
{
    switch (width) {
    case WIDTH_BYTE:
        return *(const uint8_t *)at;
    case WIDTH_WORD:
        return *(const uint16_t *)at;
    default:
        return half_word(*(const uint32_t *)at, width == WIDTH_LOW);
    }
}

static const void *object_of(enum owner owner, uint8_t axis)
{
    switch (owner) {
    case OWNER_FAULTS:
        return faults_record();
    case OWNER_WATCH:
        return reference_watch();
    case OWNER_GRID:
        return lock_grid_now();
    case OWNER_MARK:
        return mark_now();
    case OWNER_SEEK:
        return seek_now();
    case OWNER_SETTINGS:
        return settings_now();
    case OWNER_TRAFFIC:
        return traffic_counters();
    case OWNER_AXIS:
    default:
        return axes_get(axis);
    }
}

static uint16_t member_word(uint16_t value, uint8_t kind, uint8_t axis)
{
    enum owner owner = (enum owner)(kind & OWNER_MASK);
    // Most are an axis's.
    const void *object =
        SEVERAL_AXES && owner == OWNER_AXIS ? axes_get(axis) : object_of(owner, axis);

    return word_at((const uint8_t *)object + value, kind & (uint8_t)~OWNER_MASK);
}

static inline uint16_t word_of(const struct source *entry, uint8_t axis)
{
    struct source source = {.kind = KIND_CONSTANT};

    flash_copy(&source, entry, sizeof source);
    if (source.kind == KIND_CONSTANT) {
        return source.value;
    }
    return source.kind <= KIND_CALL_LOW ? source.call(axis, source.kind == KIND_CALL_LOW)
                                        : member_word(source.value, source.kind, axis);
}

// The place of a register among the sources.
static inline uint8_t place_of(uint16_t address, uint8_t *axis)
{
    uint8_t place = (uint8_t)address;

    *axis = 0;
    if (address >= MORE_BASE) {
        place = (uint8_t)(place - (MORE_BASE - MORE_PLACE));
    } else if (CONFIG_AXES > 1 && place >= REG_AXIS_BASE) {
        *axis = (uint8_t)(place - REG_AXIS_BASE) / REG_AXIS_STRIDE;
        place = (uint8_t)(place - *axis * REG_AXIS_STRIDE);
    }
    return place;
}

uint16_t report_word(uint16_t address)
{
    uint8_t axis = 0;
    uint8_t place = place_of(address, &axis);

    return word_of(&sources[place], axis);
}

#if SEVERAL_AXES
// The place behind those that are read together. The position of an axis begins anew.
static inline uint8_t end_of(uint8_t place)
{
    if (place < AXIS(0)) {
        return AXIS(0);
    }
    if (place < AXIS(REG_AXIS_position_steps)) {
        return AXIS(REG_AXIS_position_steps);
    }
    return place < MORE_PLACE ? MORE_PLACE : SOURCES;
}

uint8_t report_words(uint16_t address, uint8_t count, uint8_t *to)
{
    uint8_t axis = 0;
    uint8_t place = place_of(address, &axis);
    uint8_t words = (uint8_t)(end_of(place) - place);
    const struct source *entry = &sources[place];

    words = count < words ? count : words;
    // A position takes as long as all other registers of an axis; in front of an axis are the
    // board's registers, or those of another axis.
    if (place == AXIS(REG_AXIS_position_steps) || place == AXIS(0) ||
        place == MORE_PLACE) {
        interlude();
    }
    for (uint8_t left = words; left != 0; left--) {
        put_word(to, word_of(entry++, axis));
        to += 2;
    }
    return words;
}
#endif
