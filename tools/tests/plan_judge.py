# SPDX-License-Identifier: MIT
"""The judge of planned lines: the independent reference in exact arithmetic."""

from fractions import Fraction

from pixstep.lines import core, exact
from pixstep.lines.line import Line
from pixstep.lines.units import edge_tick
from pixstep_trials.cases import LineCase


def judge(tested: LineCase) -> None:
    """Require the planned ticks and table of a case to be right in exact arithmetic."""
    line, period = tested.line, tested.period
    ticks = core.plan(line, tested.pixel_hz, tick_hz=tested.tick_hz).columns()[:, 1].tolist()
    assert len(ticks) == line.total_steps
    for step, (tick, (_, when)) in enumerate(
        zip(ticks, exact.exact_instants(line, period), strict=True), 1
    ):
        assert when.strictly_within_one(tick), f"step {step}: tick {tick}, exact {float(when)}"
    for pixel, done in exact.edge_ends(line):
        assert ticks[done - 1] == edge_tick(pixel, period), f"last step of pixel {pixel}"
    rows = core.plan(line, tested.pixel_hz, tick_hz=tested.tick_hz, pixels=True).columns()
    assert rows[:, 0].tolist() == list(range(1, line.pixels + 1))
    assert rows[:, 1].tolist() == [edge_tick(k, period) for k in range(1, line.pixels + 1)]
    assert rows[:, 2].tolist() == brute_force_positions(line, period)


def brute_force_positions(line: Line, period: Fraction) -> list[int]:
    """Return expected positions by counting exact events against each edge, without a formula."""
    table = []
    position = 0
    events = (
        (when, piece.direction)
        for piece in exact.pieces(line)
        for when in (exact.instant(piece, step, period) for step in range(1, piece.steps + 1))
    )
    pending = next(events, None)
    for pixel in range(1, line.pixels + 1):
        edge = pixel * period
        while pending is not None and pending[0].at_or_before(edge):
            position += pending[1]
            pending = next(events, None)
        table.append(position)
    return table
