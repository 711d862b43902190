# SPDX-License-Identifier: MIT
"""Switches, limits and lines without the clock on the real images: what only real time shows."""

from fractions import Fraction

import numpy as np
import pytest

from bench import Bench
from effort import TRIED_BOARDS, cases
from pixstep.board import boards
from pixstep.board.errors import LineRefusedByBoardError
from pixstep.board.upload import LineUpload
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.logs import read_edges

pytestmark = pytest.mark.usefixtures("simulator")
BOARDS = TRIED_BOARDS
HZ = Fraction(100)
START, WAIT, SEEK, END, DOWN = 0x01, 0x20, 0x80, (2, 0), (3, 0)


def fastest_seek(board):
    """Return the fastest even speed of a seek, steps/pixel."""
    table = boards.load(board)
    return table.tick_hz // int(HZ) // table.seek_min_interval_ticks // 2 * 2


def queue(bench, axis, runs, flags=0):
    """Queue a plain line of these runs."""
    upload = LineUpload(bench.board, axis, [(START | flags, 0), (0, 0), *runs, END])
    upload.push()
    assert upload.done


def over(bench):
    """True when no axis moves or is about to."""
    return all(bench.state(axis) in ("done", "fault", "empty") for axis in bench.axes)


@pytest.mark.parametrize("count", [5, 50, 300])
@pytest.mark.parametrize("board", BOARDS)
def test_an_axis_moves_away_from_its_limit_whatever_its_rate_was(board, count):
    """A last step follows the stop: it must not be taken for a move towards the limit."""
    knobs = "0.0:travel=-100000..700,over=100000"
    with Bench(board, hz=HZ, extra=("--plant", knobs)) as bench:
        queue(bench, 0, [(count, 30_000)])
        bench.arm()
        assert bench.run_until_fault() == "limit_plus"
        bench.assert_rest()
        at = bench.sim.steps(0, 0)
        assert 700 <= at <= 700 + 2 + count * 2
        bench.board.command("clear_fault", [0])
        queue(bench, 0, [(-count, 8)])
        bench.arm()
        bench.until(lambda: over(bench))
        assert bench.fault() == "none"
        bench.assert_rest()
        assert bench.sim.steps(0, 0) == at - 8 * count


def test_position_is_exact_when_a_clock_edge_comes_as_a_run_is_cut_off():
    """Stopped at any distance from a clock edge: its sample must know of the cut."""
    for wait in range(0, 160_000, cases(7_300, 800)):
        with Bench("uno", hz=HZ) as bench:
            queue(bench, 0, [(100, 100)], WAIT)
            bench.arm()
            bench.run_until_steps(406)
            bench.sim.run(wait)
            bench.board.command("stop", [0])
            bench.sim.run(bench.pixel_ticks)
            assert bench.board.axis(0)["position_steps"] == bench.sim.steps(0, 0), wait


@pytest.mark.parametrize("flags", [0, SEEK])
@pytest.mark.parametrize("board", BOARDS)
def test_a_line_without_the_clock_begins_at_any_rate(board, flags):
    count = fastest_seek(board) if flags else 600
    for phase in range(cases(2, 6)):
        with Bench(board, hz=HZ) as bench:
            queue(bench, 0, [(count, 20), *([DOWN] if flags else [])], flags)
            bench.sim.run(phase * 777)
            bench.arm()
            bench.until(lambda: over(bench))
            assert bench.fault() == ("home_not_found" if flags else "none")
            bench.assert_rest()
            assert bench.count() == count * 20


@pytest.mark.parametrize(
    ("board", "axes"),
    [("uno", [0]), ("mega", [1, 0, 2, 3]), ("mega", [3, 0, 1, 2]), ("m1284", [1, 0])],
)
def test_the_fastest_seek_places_its_edge(tmp_path, board, axes):
    """Each step interrupt may come between the edge and the look at where it fell."""
    count, path = fastest_seek(board), tmp_path / "edges.csv"
    offsets = set()
    for trial in range(cases(5, 16)):
        knobs = f"0.{axes[0]}:home={4321 + 7 * trial},delay={trial * 137},over=1000000"
        with Bench(board, axes, HZ, path, extra=("--plant", knobs)) as bench:
            queue(bench, axes[0], [(count, 40), DOWN], SEEK)
            for axis in axes[1:]:
                queue(bench, axis, [(450, 60)], WAIT)
            bench.arm()
            bench.until(lambda: over(bench))
            bench.sim.command("flush")
            rising = read_edges(path).axis(0, axes[0]).rising
            found = bench.board.inputs()
            edge = int(bench.sim.command(f"switches 0 {axes[0]}").split()[7])
        assert found["trip_code"] == 1
        assert found["trip_position_steps"] == np.count_nonzero(rising <= edge)
        offsets.add(edge - found["trip_ticks"])
    assert len(offsets) == 1, offsets
    with Bench(board, axes[:1], HZ) as bench, pytest.raises(LineRefusedByBoardError) as refusal:
        queue(bench, axes[0], [(count + 2, 40), DOWN], SEEK)
    assert refusal.value.name == "too_fast"


def test_a_seek_begins_while_other_axes_keep_the_board_busy():
    """Its own account is old by then, and a clock edge of its timer may be waiting."""
    ramp = [5, 25, *range(50, 180, 20)]
    line = Line((*ramp, *([190, 189, 188, 189] * 12), *ramp[::-1]), PLAIN)
    for phase in range(0, 10, cases(4, 1)):
        with Bench("mega", range(4), HZ) as bench:
            for axis in range(3):
                bench.load(line, axis)
            queue(bench, 3, [(20, 30), DOWN], SEEK)
            bench.board.command("arm", [0, 1, 2])
            bench.run_until_steps(1500)
            bench.sim.run(phase * bench.pixel_ticks // 10)
            bench.board.command("arm", [3])
            bench.until(lambda: over(bench))
            assert bench.fault() == "home_not_found"
            assert bench.count(3) == 600
            bench.assert_rest()
