# SPDX-License-Identifier: MIT
"""Plain lines whose counts jump wildly: every step is made, and every edge is right.

What one pixel leaves in the step ring is what the next one has to do with: few steps, which are
entries of their own, in front of thousands, which are pulse trains.
"""

import random
from fractions import Fraction

import pytest

from pixstep.lines.line import PLAIN, Line
from pixstep.simulation import judge
from pixstep.simulation.job import FREE, LOCK, START, LineExperiment, run_job

pytestmark = pytest.mark.usefixtures("simulator")

# The most steps a second of each axis at once.
BOARDS = {"uno": ((0,), 200_000), "mega": ((0, 1, 2, 3), 50_000), "m1284": ((0, 1), 100_000)}


def assert_right(tmp_path, board, lines, hz, sync="start"):
    result = run_job(LineExperiment(board, lines, Fraction(hz), sync=sync), tmp_path)
    assert (result.trouble, result.refused) == ([], None)
    assert judge.judge(result).summary["reasons"] == []


def wild(some, most, pixels):
    """Return a line of stretches of few steps, of some, and of many up to `most`."""
    counts = []
    while len(counts) < pixels:
        kind = some.random()
        if kind < 0.5:
            counts += [some.randint(0, 26)] * some.randint(1, 30)
        elif kind < 0.6:
            counts += [some.randint(1, 130) for _ in range(some.randint(1, 9))]
        else:
            counts += [some.randint(100, most) for _ in range(some.randint(1, 3))]
    return Line(tuple(counts[:pixels]), PLAIN)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("board", BOARDS)
def test_wild_counts(tmp_path, board, seed):
    axes, top = BOARDS[board]
    some = random.Random(f"{board} {seed}")
    hz = some.choice((20, 29, 37, 60))
    most = min(top // hz, 2600)
    lines = {axis: wild(some, most, 60) for axis in axes}
    assert_right(tmp_path, board, lines, hz, some.choice((FREE, START, LOCK)))


# The ring has room for 20 entries when the long pixel comes, which has 22.
@pytest.mark.parametrize("before", [20, 23, 25])
def test_the_longest_train_behind_a_full_ring(tmp_path, before):
    line = Line((21,) * before + (2032,) * 2 + (21,) * 3, PLAIN)
    assert_right(tmp_path, "mega", {3: line}, 29)
