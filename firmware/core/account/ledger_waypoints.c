// SPDX-License-Identifier: MIT
// The C of ledger_waypoints.S.
#include "account/ledger_waypoints.h"

#include "base/require.h"       // REQUIRE
#include "ring/step_ring_sum.h" // step_ring_sum

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

// The assembly takes the time that the writer of the stream noted; the ring must tell the same.
static void pass_time(struct ledger *ledger,
                      const struct stream *stream,
                      const struct waypoint *waypoint)
{
    uint8_t slot = stream->retired;
    uint32_t ticks = step_ring_sum(stream->ring, &slot, waypoint->slot);

    ledger->loaded_ticks += ticks;
    REQUIRE(slot == waypoint->slot &&
            (ledger->loaded_ticks & 0xFFFFFFuL) ==
                ((waypoint_ticks(waypoint) + stream->delay_ticks) & 0xFFFFFFuL));
}

bool ledger_pass_waypoints(struct ledger *ledger, struct stream *stream, uint8_t tail)
{
    while (stream_has_waypoint(stream) && waypoint_is_plain(stream_waypoint(stream))) {
        const struct waypoint *waypoint = stream_waypoint(stream);
        uint8_t count = (uint8_t)(waypoint->slot - stream->retired);

        if ((uint8_t)(tail - stream->retired) < count) {
            break;
        }
        pass_time(ledger, stream, waypoint);
        stream->retired = waypoint->slot;
        ledger_pass_periods(ledger, count);
        if (waypoint->way == WAYPOINT_PLAIN) {
            ledger_pass_edge(ledger, ledger->position_steps, waypoint->position);
        }
        stream_pass_waypoint(stream);
    }
    return stream_on_plain_way(stream, tail);
}

#endif
