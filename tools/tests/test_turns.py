# SPDX-License-Identifier: MIT
"""Direct reversals at the shortest interval that the board allows, on all axes at once."""

from fractions import Fraction

import numpy as np
import pytest

from bench import Bench
from pixstep.board.errors import LineRefusedByBoardError
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.edges import read_edges

HZ = Fraction(100)
STROKE_PX = 6


def turning(count):
    """Return a line that turns four times from one pixel to the next."""
    return Line(tuple(way * count for way in (1, -1, 1, -1, 1) for _ in range(STROKE_PX)), PLAIN)


def accepted(bench, count):
    """Upload to every axis; False if the board refuses."""
    try:
        for axis in bench.axes:
            bench.load(turning(count), axis)
    except LineRefusedByBoardError as error:
        assert error.name == "reversal_too_fast"
        bench.board.command("discard", bench.axes)
        return False
    return True


def fastest(bench):
    """Leave the fastest line that the board accepts in its queues; return its count."""
    low, high = 1, 400
    while high - low > 1:
        middle = (low + high) // 2
        if accepted(bench, middle):
            bench.board.command("discard", bench.axes)
            low = middle
        else:
            high = middle
    assert accepted(bench, low)
    return low


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize("setting_us", [20, 300])
@pytest.mark.parametrize(("board", "axes"), [("uno", 1), ("mega", 1), ("mega", 4), ("m1284", 2)])
def test_direction_times_at_the_limit(tmp_path, board, axes, setting_us):
    path = tmp_path / "edges.csv"
    with Bench(board, range(axes), HZ, edges=path) as bench:
        bench.board.write_setting("dir_setup_us", setting_us)
        bench.board.write_setting("dir_hold_us", setting_us)
        count = fastest(bench)
        bench.arm()
        while any(bench.state(axis) != "done" for axis in bench.axes):  # the serial line is busy
            assert bench.fault() == "none", count
        bench.sim.wait_s(0.02)
        bench.sim.command("flush")
        log = read_edges(path)
    for axis in range(axes):
        edges = log.axis(0, axis)
        assert len(edges.rising) == 5 * STROKE_PX * count
        turns = edges.direction_cycles
        after = np.searchsorted(edges.rising, turns)
        inside = (after > 0) & (after < len(edges.rising))
        gap_ticks = setting_us * (bench.sim.tick_hz // 1_000_000)
        assert np.count_nonzero(inside) == 4
        assert np.all(edges.rising[after[inside]] - turns[inside] >= gap_ticks)
        assert np.all(turns[inside] - edges.rising[after[inside] - 1] >= gap_ticks)
