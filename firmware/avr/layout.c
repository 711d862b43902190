// SPDX-License-Identifier: MIT
// What the assembly has to know of the structs and constants of C. The build compiles this file to
// assembly for each board, with the board's options, and cmake/layout.cmake makes a header of the
// values: layout.h. No image contains this file.
//
//     LAYOUT(NAME, value)             #define NAME value
//     OFFSET(NAME, struct x, member)  bytes from the beginning of the struct to the member
//
// A struct whose members move, or a limit that changes, reaches the assembly by the next build.
#include <stddef.h> // offsetof

#include "account/ledger.h"        // struct ledger
#include "account/records.h"       // struct records
#include "avr/hal/capture_queue.h" // struct capture_queue
#include "avr/hal/step_isr.h"      // struct step_engine
#include "avr/hal/uart_place.h"    // struct uart_place
#include "build_features.h"        // SEVERAL_AXES, FEATURE_CLOCK_STATISTICS
#include "clock/pixel_period.h"    // struct pixel_period
#include "line/even_rate.h"        // struct even_rate
#include "line/line.h"             // struct line
#include "line/segment_pack.h"     // SEGMENT_*
#include "line/segment_queue.h"    // struct segment_queue
#include "ring/captured_edge.h"    // struct captured_edge
#include "steps/curve_flat.h"      // struct curve_flat
#include "steps/curve_steep.h"     // struct curve_steep
#include "steps/even_pixel.h"      // EVEN_PIXEL_*
#include "steps/walk.h"            // struct walk
#include "stream/even.h"           // struct even
#include "stream/stream.h"         // struct stream

#define LAYOUT(name, value) __asm__ volatile("\n;layout " #name " %0" : : "i"(value))
#define OFFSET(name, type, member) LAYOUT(name, offsetof(type, member))

// What the assembly takes for granted.
_Static_assert(
    LINE_GRID_EXACT == 0 && LEDGER_NO_TRAIN == UINT8_MAX && WAYPOINT_PLACE == UINT8_MAX &&
        EVEN_PIXEL_WAITS == UINT8_MAX,
    "compared with a register of zeros, or found by one instruction that counts");
_Static_assert(offsetof(struct line, source.queue) == 0 &&
                   offsetof(struct kept_record, actual_steps) == 0 &&
                   offsetof(struct records_thinning, every) == 0,
               "reached without an offset");
_Static_assert(offsetof(struct waypoint, ticks_high) ==
                   offsetof(struct waypoint, ticks_low) + 2,
               "a number of three bytes");
_Static_assert(offsetof(struct curve_steep, at.step) ==
                       offsetof(struct curve_steep, at.step_low) + 2 &&
                   offsetof(struct step_ring, high) == STEP_RING_SLOTS,
               "reached from the place before");

// A byte of bit-fields: the flags of a line and its source, after the segment in work.
#define LINE_FLAGS (offsetof(struct line, source.segment) + sizeof(struct segment))

void layout_base(void);
void layout_base(void)
{
    OFFSET(WIDE_LOW, struct wide, low);
}

void layout_curves(void);
void layout_curves(void)
{
    OFFSET(CURVE_FLAT_RESIDUAL, struct curve_flat, residual);
    OFFSET(CURVE_FLAT_GAIN, struct curve_flat, gain);
    OFFSET(CURVE_FLAT_DIFFERENCE, struct curve_flat, difference);
    OFFSET(CURVE_FLAT_GAIN_GROWTH, struct curve_flat, gain_growth);
    OFFSET(CURVE_FLAT_SLOPE_GROWTH, struct curve_flat, slope_growth);
    OFFSET(CURVE_FLAT_TWICE_HALF, struct curve_flat, twice_half);
    OFFSET(CURVE_FLAT_TOP, struct curve_flat, top);

    OFFSET(CURVE_STEEP_RESIDUAL, struct curve_steep, at.residual);
    OFFSET(CURVE_STEEP_SLOPE, struct curve_steep, at.slope);
    OFFSET(CURVE_STEEP_STEP, struct curve_steep, at.step_low);
    OFFSET(CURVE_STEEP_HALF, struct curve_steep, at.half);
    OFFSET(CURVE_STEEP_LAST, struct curve_steep, last_ticks);
    OFFSET(CURVE_STEEP_CHANGE, struct curve_steep, change);
    OFFSET(CURVE_STEEP_GOOD, struct curve_steep, good);
    OFFSET(CURVE_STEEP_SUM, struct curve_steep, tops);
    OFFSET(CURVE_STEEP_FIRST_HIGH, struct curve_steep, first_high);
    LAYOUT(CURVE_STEEP_MISS_MAX, CURVE_STEEP_MISS_MAX);
    LAYOUT(CURVE_STEEP_LIMIT, CURVE_STEEP_LIMIT);
}

void layout_evens(void);
void layout_evens(void)
{
    OFFSET(EVEN_BASE, struct even, base_ticks);
    OFFSET(EVEN_REMAINDER, struct even, remainder);
    OFFSET(EVEN_STEPS, struct even, steps);
    OFFSET(EVEN_SUM, struct even, sum);

    OFFSET(EVEN_PIXEL_TICKS, struct even_rate, ticks);
    OFFSET(EVEN_PIXEL_BASE, struct even_rate, base_ticks);
    OFFSET(EVEN_PIXEL_STEPS, struct even_rate, steps);
    OFFSET(EVEN_PIXEL_REMAINDER, struct even_rate, remainder);
    LAYOUT(EVEN_PIXEL_MOST_STEPS, EVEN_PIXEL_MAX_STEPS);
    LAYOUT(EVEN_PIXEL_BASE_MIN, EVEN_PIXEL_MIN_TICKS);
    LAYOUT(EVEN_PIXEL_BASE_MAX_HIGH, (EVEN_PIXEL_MAX_INTERVAL + 1u) >> 8);
    LAYOUT(EVEN_PIXEL_TICKS_TOO_BIG, (EVEN_PIXEL_MAX_TICKS >> 16) + 1);
    LAYOUT(EVEN_PIXEL_COST, EVEN_PIXEL_COST);
    LAYOUT(EVEN_PIXEL_RING_CAPACITY, STEP_RING_CAPACITY);
}

void layout_stream(void);
void layout_stream(void)
{
    OFFSET(EVEN_PIXEL_RING, struct stream, ring);
    OFFSET(EVEN_PIXEL_HEAD, struct stream, head);
    OFFSET(EVEN_PIXEL_RETIRED, struct stream, retired);
    OFFSET(EVEN_PIXEL_WAYPOINT_HEAD, struct stream, waypoint_head);
    OFFSET(EVEN_PIXEL_WAYPOINT_PLACED, struct stream, waypoint_placed);
    OFFSET(EVEN_PIXEL_WAYPOINT_TAIL, struct stream, waypoint_tail);
    LAYOUT(EVEN_PIXEL_WAYPOINT_COUNT, STREAM_WAYPOINTS);
    OFFSET(EVEN_PIXEL_PLAIN, struct stream, plain);
    OFFSET(EVEN_PIXEL_DELAY_TICKS, struct stream, delay_ticks);
    OFFSET(EVEN_PIXEL_END_TICKS, struct stream, end_ticks);
    OFFSET(EVEN_PIXEL_WAYPOINTS, struct stream, waypoints);
    LAYOUT(EVEN_PIXEL_LAG_MOST, STREAM_LAG_MOST);

    OFFSET(EVEN_PIXEL_WAYPOINT_SLOT, struct waypoint, slot);
    OFFSET(EVEN_PIXEL_WAYPOINT_WAY, struct waypoint, way);
    OFFSET(EVEN_PIXEL_WAYPOINT_POSITION, struct waypoint, position);
    OFFSET(EVEN_PIXEL_WAYPOINT_TICKS, struct waypoint, ticks_low);
    LAYOUT(EVEN_PIXEL_WAYPOINT_BYTES, sizeof(struct waypoint));
    LAYOUT(EVEN_PIXEL_WAY_PLAIN, WAYPOINT_PLAIN);
}

void layout_line(void);
void layout_line(void)
{
    OFFSET(EVEN_PIXEL_COUNT, struct line, source.segment.count);
    OFFSET(EVEN_PIXEL_REPEAT, struct line, source.segment.repeat);
    LAYOUT(EVEN_PIXEL_FLAGS, LINE_FLAGS);
    OFFSET(EVEN_PIXEL_RATE, struct line, even);
    OFFSET(EVEN_PIXEL_CURVE_HALF, struct line, curve_half);
    OFFSET(EVEN_PIXEL_SPEED, struct line, speed);
    OFFSET(EVEN_PIXEL_POSITION, struct line, position);
    OFFSET(EVEN_PIXEL_TO_EDGE, struct line, to_edge_ticks);
    OFFSET(EVEN_PIXEL_ROOM, struct line, room);
    OFFSET(EVEN_PIXEL_GRID_MODE, struct line, edges.mode);
    OFFSET(EVEN_PIXEL_GRID, struct line, edges.exact);

    OFFSET(EVEN_PIXEL_QUEUE_BYTES, struct segment_queue, out.bytes);
    OFFSET(EVEN_PIXEL_QUEUE_MASK, struct segment_queue, out.mask);
    OFFSET(EVEN_PIXEL_QUEUE_AT, struct segment_queue, out.at);
    OFFSET(EVEN_PIXEL_QUEUE_LAST, struct segment_queue, out.last);
    OFFSET(EVEN_PIXEL_QUEUE_HEAD, struct segment_queue, head);
    LAYOUT(EVEN_PIXEL_NEAR_ZERO, SEGMENT_NEAR_ZERO);
    LAYOUT(EVEN_PIXEL_NEAR_LAST, SEGMENT_NEAR_LAST);
    LAYOUT(EVEN_PIXEL_SHORT_RUN, SEGMENT_SHORT_RUN);
    LAYOUT(EVEN_PIXEL_RUN, SEGMENT_RUN);
}

void layout_ledger(void);
void layout_ledger(void)
{
    OFFSET(LEDGER_PULSE, struct ledger, pulse);
    OFFSET(LEDGER_NEGATIVE, struct ledger, negative);
    OFFSET(LEDGER_TRAIN, struct ledger, train);
    OFFSET(LEDGER_IDLE_SEEN, struct ledger, idle_seen);
    OFFSET(LEDGER_FRESH, struct ledger, fresh);
    OFFSET(LEDGER_LOADED, struct ledger, loaded_ticks);
    OFFSET(LEDGER_POSITION, struct ledger, position_steps);
    OFFSET(LEDGER_ORIGIN, struct ledger, line_origin);
    OFFSET(LEDGER_PIXEL, struct ledger, pixel);

    OFFSET(LEDGER_RECORDS, struct ledger, records);
    OFFSET(LEDGER_RECORDS_NEWEST, struct ledger, records.newest);
    OFFSET(LEDGER_RECORDS_COUNT, struct ledger, records.count);
    OFFSET(LEDGER_RECORDS_PASSING, struct ledger, records.passing);
    OFFSET(LEDGER_RECORDS_MADE, struct ledger, records.made);
    OFFSET(LEDGER_RECORDS_TO_NEXT, struct ledger, records.to_next);
    OFFSET(LEDGER_RECORDS_KEPT, struct ledger, records.kept);
    OFFSET(LEDGER_RECORD_BEYOND, struct kept_record, beyond_steps);
    OFFSET(LEDGER_RECORD_PIXEL, struct kept_record, pixel);
    LAYOUT(LEDGER_RECORD_BYTES, sizeof(struct kept_record));
#if FEATURE_CLOCK_STATISTICS
    OFFSET(LEDGER_RECORDS_SHOWN, struct ledger, records.shown_ticks);
    OFFSET(LEDGER_RECORDS_EARLY, struct ledger, records.early_ticks);
    LAYOUT(LEDGER_RECORDS_EARLIER, RECORDS_EARLY);
    OFFSET(LEDGER_RECORD_ERROR, struct kept_record, edge_error_ticks);
#endif

    OFFSET(LEDGER_SAMPLE_TAIL, struct engine_sample, tail);
    OFFSET(LEDGER_SAMPLE_CUT, struct engine_sample, cut);
    OFFSET(LEDGER_SAMPLE_IDLE, struct engine_sample, idle_count);
}

void layout_clock(void);
void layout_clock(void)
{
    OFFSET(PIXEL_PERIOD_WHOLE, struct pixel_period, whole_ticks);
    OFFSET(PIXEL_PERIOD_REMAINDER, struct pixel_period, remainder);
    OFFSET(PIXEL_PERIOD_DIVISOR, struct pixel_period, divisor);
    OFFSET(PIXEL_GRID_PERIOD, struct pixel_grid, period);
    OFFSET(PIXEL_GRID_SUM, struct pixel_grid, sum);
}

void layout_step_isr(void);
void layout_step_isr(void)
{
    LAYOUT(STEP_ISR_ENGINE_SIZE, sizeof(struct step_engine));
    OFFSET(STEP_ISR_TAIL, struct step_engine, tail);
    OFFSET(STEP_ISR_STATE, struct step_engine, state);
    OFFSET(STEP_ISR_IDLE_COUNT, struct step_engine, idle_count);
    OFFSET(STEP_ISR_LEFT, struct step_engine, left);
    OFFSET(STEP_ISR_TRAIN_HIGH, struct step_engine, train_high);
    OFFSET(STEP_ISR_TRAINS, struct step_engine, trains);
    OFFSET(STEP_ISR_STOP, struct step_engine, stop);
    OFFSET(STEP_ISR_PULSE, struct step_engine, pulse);
    OFFSET(STEP_ISR_CUT, struct step_engine, cut);

    LAYOUT(STEP_ISR_TRAIN_SIZE, sizeof(struct pulse_train));
    OFFSET(STEP_ISR_SUM, struct pulse_train, sum);
    OFFSET(STEP_ISR_AFTER_SHORT, struct pulse_train, after_short);
    OFFSET(STEP_ISR_AFTER_LONG, struct pulse_train, after_long);
    OFFSET(STEP_ISR_SHORT_LOW, struct pulse_train, short_low);
    OFFSET(STEP_ISR_LONG_LOW, struct pulse_train, long_low);
    OFFSET(STEP_ISR_TOP_HIGH, struct pulse_train, top_high);

    LAYOUT(STEP_ISR_RING_SIZE, sizeof(struct step_ring));
    OFFSET(STEP_ISR_HIGH_OFFSET, struct step_ring, high);
}

void layout_captures(void);
void layout_captures(void)
{
    OFFSET(CAPTURED_EDGE_TICKS, struct captured_edge, ticks);
    OFFSET(CAPTURED_EDGE_TAIL, struct captured_edge, tail);
    OFFSET(CAPTURED_EDGE_LEFT_OR_CUT, struct captured_edge, left_or_cut);
    OFFSET(CAPTURED_EDGE_IDLE_COUNT, struct captured_edge, idle_count);
    OFFSET(CAPTURED_EDGE_NOTES, struct captured_edge, notes);
    LAYOUT(CAPTURED_EDGE_SIZE, sizeof(struct captured_edge));

    OFFSET(CAPTURE_QUEUE_HEAD, struct capture_queue, head);
    OFFSET(CAPTURE_QUEUE_TAIL, struct capture_queue, tail);
    OFFSET(CAPTURE_QUEUE_LOST, struct capture_queue, lost);
    OFFSET(CAPTURE_FIRST_LEFT, struct capture_queue, first_left);
    OFFSET(CAPTURE_FIRST_TAIL, struct capture_queue, first_tail);
    OFFSET(CAPTURE_FIRST_IDLE_LOW, struct capture_queue, first_idle_low);
#if CONFIG_AXES > 1
    OFFSET(CAPTURE_FIRST_COUNTER, struct capture_queue, first_counter);
    OFFSET(CAPTURE_FIRST_UNIT, struct capture_queue, first_unit);
#endif
    OFFSET(CAPTURE_QUEUE_ENTRIES, struct capture_queue, entries);
}

void layout_uart(void);
void layout_uart(void)
{
    OFFSET(UART_FIRST, struct uart_place, first_byte);
    OFFSET(UART_NEXT, struct uart_place, next_byte);
    OFFSET(UART_END, struct uart_place, end_byte);
    OFFSET(UART_SILENCE, struct uart_place, first_silence);
    OFFSET(UART_OVERRUNS, struct uart_place, overruns);
    OFFSET(UART_CONTROL, struct uart_place, control_after);
}
