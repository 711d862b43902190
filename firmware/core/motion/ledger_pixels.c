// SPDX-License-Identifier: MIT
#include "motion/ledger_pixels.h"

#include <stddef.h> // offsetof

#include "build_features.h" // FEATURE_CLOCK_STATISTICS
#include "motion/even_pixel_layout.h"
#include "motion/ledger_data.h" // struct ledger
#include "motion/ledger_layout.h"
#include "motion/stream.h" // struct stream

#if defined(__AVR__)

#define IN_RECORDS(member) (LEDGER_RECORDS + offsetof(struct records, member))

_Static_assert(offsetof(struct ledger, pulse) == LEDGER_PULSE &&
                   offsetof(struct ledger, negative) == LEDGER_NEGATIVE &&
                   offsetof(struct ledger, fresh) == LEDGER_FRESH &&
                   offsetof(struct ledger, loaded_ticks) == LEDGER_LOADED &&
                   offsetof(struct ledger, position_steps) == LEDGER_POSITION &&
                   offsetof(struct ledger, line_origin) == LEDGER_ORIGIN &&
                   offsetof(struct ledger, pixel) == LEDGER_PIXEL &&
                   offsetof(struct ledger, records) == LEDGER_RECORDS &&
                   IN_RECORDS(newest) == LEDGER_RECORDS_NEWEST &&
                   IN_RECORDS(count) == LEDGER_RECORDS_COUNT &&
                   IN_RECORDS(passing) == LEDGER_RECORDS_PASSING &&
                   IN_RECORDS(made) == LEDGER_RECORDS_MADE &&
                   IN_RECORDS(to_next) == LEDGER_RECORDS_TO_NEXT &&
                   IN_RECORDS(kept) == LEDGER_RECORDS_KEPT &&
                   offsetof(struct kept_record, actual_steps) == 0 &&
                   offsetof(struct kept_record, beyond_steps) == LEDGER_RECORD_BEYOND &&
                   offsetof(struct kept_record, pixel) == LEDGER_RECORD_PIXEL &&
                   sizeof(struct kept_record) == LEDGER_RECORD_BYTES &&
                   offsetof(struct records_thinning, every) == 0 &&
                   offsetof(struct records_thinning, error_ticks) ==
                       LEDGER_THINNING_ERROR,
               "known to ledger_pixels.S");

_Static_assert(offsetof(struct stream, retired) == EVEN_PIXEL_RETIRED &&
                   offsetof(struct stream, mark_placed) == EVEN_PIXEL_MARK_PLACED &&
                   offsetof(struct stream, mark_tail) == EVEN_PIXEL_MARK_TAIL &&
                   offsetof(struct stream, marks) == EVEN_PIXEL_MARKS &&
                   offsetof(struct stream, behind_periods) == EVEN_PIXEL_BEHIND_PERIODS &&
                   STREAM_UNKNOWN == UINT8_MAX &&
                   offsetof(struct stream_mark, slot) == EVEN_PIXEL_MARK_SLOT &&
                   offsetof(struct stream_mark, position) == EVEN_PIXEL_MARK_POSITION &&
                   offsetof(struct stream_mark, ticks) == EVEN_PIXEL_MARK_TICKS &&
                   sizeof(struct stream_mark) == EVEN_PIXEL_MARK_BYTES,
               "known to ledger_pixels.S");

#if FEATURE_CLOCK_STATISTICS
_Static_assert(IN_RECORDS(shown_ticks) == LEDGER_RECORDS_SHOWN &&
                   IN_RECORDS(early_ticks) == LEDGER_RECORDS_EARLY &&
                   RECORDS_EARLY == LEDGER_RECORDS_EARLIER &&
                   offsetof(struct kept_record, edge_error_ticks) == LEDGER_RECORD_ERROR,
               "known to ledger_pixels.S");
#endif

#else

void ledger_pass_periods(struct ledger *ledger, uint8_t count)
{
    uint8_t fresh = (uint8_t)(ledger->fresh + count);

    ledger->fresh = fresh < count || fresh > 3u ? 3u : fresh;
    if (ledger->pulse) {
        ledger_move_position(ledger, count);
    }
}

void ledger_pass_edge(struct ledger *ledger,
                      int32_t position_steps,
                      uint16_t expected_steps)
{
    ledger->pixel++;
    records_add(&ledger->records,
                (uint16_t)ledger->pixel,
                position_steps - ledger->line_origin,
                expected_steps);
}

bool ledger_take_pixels(struct ledger *ledger, struct stream *stream, uint8_t tail)
{
    uint8_t count = stream_whole_pixel(stream);

    while (count != 0) {
        const struct stream_mark *mark = stream_mark(stream);

        if ((uint8_t)(tail - stream->retired) < count) {
            return true;
        }
        ledger->loaded_ticks += stream_whole_ticks(stream);
        stream->retired = mark->slot;
        ledger_pass_periods(ledger, count);
        ledger_pass_edge(ledger, ledger->position_steps, mark->position);
        stream_pass_mark(stream);
        count = stream_whole_pixel(stream);
    }
    return stream_inside_newest(stream, tail);
}

#endif
