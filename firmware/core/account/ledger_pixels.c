// SPDX-License-Identifier: MIT
#include "account/ledger_pixels.h"

#include "account/ledger_data.h" // struct ledger
#include "build_features.h"      // FEATURE_CLOCK_STATISTICS
#include "stream/stream.h"       // struct stream

#if !defined(__AVR__)

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
