# SPDX-License-Identifier: MIT
"""Lines with long rests: their plan ends, soon, and is right. Rests are runs of zero pixels."""

import os
import random
import signal
import threading
from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace

import pytest

from clock import TICK_HZ
from effort import cases
from pixstep import signals
from pixstep.lines import core
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import check, refused
from pixstep.lines.units import edge_tick
from pixstep.simulation.experiment import simulate
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.logs import read_edges
from pixstep_trials.cases import Bounds, LineCase, case
from plan_judge import judge

pytestmark = pytest.mark.usefixtures("plan_program")

CLOCKS_HZ = (1, 2, 7, Fraction(2997, 100), 30, 100, 333, 500, 1000, 2500, Fraction(10000, 3), 5000)
RESTS = (1, 2, 7, 11, 12, 14, 15, 16, 17, 20, 31, 40, 130)
SHORTEST_TICKS = 100
STEPS_A_PIXEL = 30


def rested(rng: random.Random, line: Line) -> Line:
    """Return a line with runs of zeros where its motor rests: before, inside, behind."""
    counts: list[int] = []
    for count, speed in zip((*line.counts, None), (*line.speeds, 0), strict=False):
        if (not line.smooth or speed == 0) and rng.random() < 0.4:
            counts.extend([0] * rng.choice(RESTS))
        if count is not None:
            counts.append(count)
    return replace(line, counts=tuple(counts))


def random_case(rng: random.Random, decode: str) -> LineCase:
    hz = Fraction(rng.choice(CLOCKS_HZ))
    shortest = max(SHORTEST_TICKS, int(TICK_HZ / hz) // STEPS_A_PIXEL)
    while True:
        bounds = Bounds(shortest, 2, 8, reversal_ticks=shortest * 4, tick_hz=TICK_HZ)
        found = case(rng, decode, bounds, hz)
        line = rested(rng, found.line)
        if not refused(check(line)):
            return replace(found, line=line)


@pytest.mark.parametrize("decode", [SMOOTH, PLAIN])
@pytest.mark.parametrize("seed", range(cases(4, 40)))
def test_random_lines_with_rests(decode, seed):
    rng = random.Random(f"{seed} {decode} rests")
    for _ in range(25):
        judge(random_case(rng, decode))


@pytest.mark.parametrize("hz", CLOCKS_HZ)
@pytest.mark.parametrize("zeros", RESTS)
def test_a_step_behind_a_rest(zeros, hz):
    made = core.plan(Line((0,) * zeros + (1,), PLAIN), Fraction(hz), tick_hz=TICK_HZ).columns()
    assert made.tolist() == [[1, edge_tick(zeros + 1, TICK_HZ / Fraction(hz))]]


@pytest.mark.parametrize("counts", [(0,), (0,) * 40, (1,) + (0,) * 400, (0,) * 9 + (-1, 0, 1)])
def test_lines_that_hardly_move(counts):
    for hz in CLOCKS_HZ:
        judge(LineCase(Line(counts, PLAIN), Fraction(hz), TICK_HZ))


def test_empty_time_costs_nothing(monkeypatch):
    """A call of the core takes at most 65,536 periods; 20,000 pixels at 1 Hz are 10 million."""
    calls = []
    real = core.extension()

    def counted(*words):
        calls.append(words)
        return real.lib.plan_rows(*words)

    names = {name: getattr(real.lib, name) for name in dir(real.lib)}
    lib = SimpleNamespace(**(names | {"plan_rows": counted}))
    monkeypatch.setattr(core, "extension", lambda: SimpleNamespace(ffi=real.ffi, lib=lib))
    line = Line((0,) * 20_000 + (1,), PLAIN)
    assert core.plan(line, Fraction(1), tick_hz=TICK_HZ).columns()[0, 1] == 20_001 * TICK_HZ
    assert len(calls) <= 6  # period by period: 150


@pytest.mark.usefixtures("simulator")
@pytest.mark.parametrize(
    ("board", "counts"),
    [("mega", (0,) * 20 + (1, 0, 0, -2) + (0,) * 40 + (3,)), ("uno", (0,) * 40 + (1,))],
)
def test_the_plan_is_what_the_board_makes(tmp_path, board, counts):
    line, hz = Line(counts, PLAIN), Fraction(2500)
    judged = simulate(LineExperiment(board, {0: line}, hz), tmp_path)
    assert judged.passed, judged.summary["reasons"]
    zero = judged.summary["line_zero_cycle"]
    made = read_edges(tmp_path / "edges.csv").axis(0, 0).rising - zero
    assert made.tolist() == core.plan(line, hz, tick_hz=TICK_HZ).columns()[:, 1].tolist()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_a_long_plan(number):
    line = Line((3200,) * 60_000, PLAIN)  # 192 million steps
    with signals.caught(), pytest.raises(KeyboardInterrupt):
        threading.Timer(0.3, os.kill, (os.getpid(), number)).start()
        core.plan(line, Fraction(2), tick_hz=TICK_HZ)
