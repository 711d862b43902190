# SPDX-License-Identifier: MIT
"""The judge of planned lines: the independent reference in exact arithmetic."""

from pixstep.lines import core, exact
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
    assert rows[:, 2].tolist() == exact.brute_force_positions(line, period)
