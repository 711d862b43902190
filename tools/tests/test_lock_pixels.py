# SPDX-License-Identifier: MIT
"""Lines on the pixel clock whose pixels are slow, long, without steps or turn, in the simulator."""

import random
from itertools import pairwise

import pytest

from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.simulation.job import FREE, LOCK, START
from pixstep.simulation.pixel_clock import ClockFlaws
from test_lock_sim import BOARDS, kept, run


# Slow steps take the decoder longest; with a lead of one pixel at these clocks an edge that is
# missing, and bridged late, would leave too little time for four axes.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("hz", [80, 100, 120])
def test_missing_edges_cost_slow_axes_nothing(tmp_path, hz):
    speeds = [*range(0, 20, 2), *range(20, 0, -2)] * 3
    slow = Line(tuple((a + b) // 2 for a, b in pairwise([*speeds, 0])), SMOOTH)
    turning = Line((3, 0, -7, 12, -1) * 12, PLAIN)
    lines = {0: slow, 1: turning, 2: slow, 3: turning}
    result, judged = run(tmp_path, "mega", lines, hz, flaws=ClockFlaws(drop=7))
    assert not result.trouble and judged.summary["clock"]["missing_edges"] > 5
    assert all(axis["steps"] == axis["expected_steps"] for axis in judged.summary["axes"])


# A pixel without steps is time that the feed keeps for the step behind it. Where a missing edge is
# bridged late, what it keeps beyond a little is time that the decoder has not got.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("board", BOARDS)
@pytest.mark.parametrize(("hz", "divider"), [("97.5", 2), (110, 2), (100, 1), ("120.6", 3)])
def test_missing_edges_cost_lines_with_zero_pixels_nothing(tmp_path, board, hz, divider):
    lines = {0: Line((*(0,) * 3, *(3, 0, 1, 0, 0, 4) * 8), PLAIN)}
    _, judged = run(
        tmp_path, board, lines, hz, divider=divider, flaws=ClockFlaws(drop=7), pixel_ppm=3000
    )
    assert judged.summary["reasons"] == [] and judged.summary["clock"]["missing_edges"] > 5


# A step in a hundred milliseconds is some fifty entries of the ring, each of which costs as much as
# several steps of a fast line: the other axes, and the clock's edges, wait meanwhile.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("board", "axes", "hz", "divider", "counts"),
    [
        ("mega", 4, 300, 64, (0, *(5,) * 8)),
        ("mega", 4, 691, 135, (1,) * 10),
        ("mega", 4, 1257, 206, (0, 0, 0, *(8,) * 8)),
        ("mega", 4, 1614, 297, (4, 15, 3, 4, 11, 19, 14, 3)),
        ("mega", 4, 2400, 500, (8,) * 8),
        ("uno", 1, 1250, 500, (8,) * 8),
        ("uno", 1, 2000, 500, (8,) * 8),
        ("uno", 1, 2020, 525, (0, 0, 0, 1, 3, 1, 1, 0)),
    ],
)
def test_slow_pixels_of_many_edges(tmp_path, board, axes, hz, divider, counts):
    lines = dict.fromkeys(range(axes), Line(counts, PLAIN))
    _, judged = run(tmp_path, board, lines, hz, divider=divider)
    for axis in lines:
        assert kept(judged, axis)["max_error_ticks"] < 1.5


def mixed(seed, least, most, turns):
    """Counts between two limits, the sign of which changes in this share of the pixels."""
    source, sign, counts = random.Random(seed), 1, []
    for _ in range(120):
        sign = -sign if source.random() < turns else sign
        counts.append(sign * source.randint(least, most))
    return Line(tuple(counts), PLAIN)


# Such pixels are decoded by pieces, which takes longer: docs/TIMING.md says how fast.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("sync", "axes", "hz", "least", "most", "turns"),
    [
        (LOCK, 4, 600, 1, 3, 0.4),
        (START, 4, 800, 1, 3, 0.4),
        (LOCK, 3, 800, 1, 3, 0.4),
        (LOCK, 2, 1200, 1, 2, 0.4),
        (LOCK, 4, 1000, 0, 20, 0),
    ],
)
def test_pixels_that_turn_or_have_no_steps(tmp_path, sync, axes, hz, least, most, turns):
    lines = {axis: mixed(axis, least, most, turns) for axis in range(axes)}
    _, judged = run(tmp_path, "mega", lines, hz, sync=sync)
    assert judged.summary["reasons"] == []


# Lines that do not wait for the clock begin one after the other, as soon as the ring of each is
# full: the judge asks for no common line zero.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("hz", [30, 50, 80, 100, 120])
def test_slow_axes_that_wait_for_no_clock(tmp_path, hz):
    lines = {axis: Line((1, *(2,) * 20, 1), SMOOTH) for axis in range(4)}
    result, judged = run(tmp_path, "mega", lines, hz, sync=FREE)
    assert not result.trouble and judged.summary["reasons"] == []
    assert all(axis["steps"] == axis["expected_steps"] for axis in judged.summary["axes"])
    assert len({axis["line_zero_cycle"] for axis in judged.summary["axes"]}) > 1


# A pixel of one step is one entry: a line that began with the first of them would be over before
# the other axes had begun, too.
@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(("steps", "hz"), [(1, 700), (20, 800), (1, 2000)])
def test_axes_of_few_steps_that_wait_for_no_clock(tmp_path, steps, hz):
    lines = {axis: Line((1 if axis else steps,) * 100, PLAIN) for axis in range(4)}
    result, judged = run(tmp_path, "mega", lines, hz, sync=FREE)
    assert not result.trouble and judged.summary["reasons"] == []
    assert [axis["steps"] for axis in judged.summary["axes"]] == [100 * steps, 100, 100, 100]
