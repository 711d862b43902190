# SPDX-License-Identifier: MIT
"""The host's line check against every image: what is refused, why, and at which pixel.

A line is sent in one block, in several, and while it moves. More lines than usual:

    pytest -c tools/pyproject.toml tools/tests/test_one_check.py --lines 20000
"""

from collections import Counter
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bench import Bench
from checked_lines import WORLDS, World, entries, long_lines, pieces
from effort import cases
from pixstep.board import boards, capability
from pixstep.board import registers as regs
from pixstep.board.errors import BUSY, BoardError, LineRefusedByBoardError
from pixstep.board.upload import LineUpload
from pixstep.lines import core
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import MARK_DIVIDER, queue_entries
from pixstep.lines.units import period_ticks

pytestmark = pytest.mark.usefixtures("simulator")

BOARDS = boards.BOARD_NAMES
FEWEST = cases(100, 200)  # lines a board, whatever --lines says
MOVING = 20  # of so many lines one more is sent while it moves
FIRST_SETTING = "pixel_hz_num"
SETTLE_S = 0.02


class Judge:
    """A simulated board that is asked what it says of lines."""

    def __init__(self, bench):
        self.bench, self.board = bench, bench.board
        self.world = None
        self.seen = Counter()

    def settle_in(self, world):
        """Give the board the settings of a world."""
        if world == self.world:
            return
        words = [world.hz.numerator >> 16, world.hz.numerator & 0xFFFF]
        words += [world.hz.denominator >> 16, world.hz.denominator & 0xFFFF]
        words += [world.driver_us, world.driver_us, world.max_acceleration]
        self.board.write_settings(self.board.map.holding(FIRST_SETTING).address, words)
        self.board.write_setting("start_stop_steps", world.start_stop_steps)
        self.world = world
        self.limits = capability.connected_limits(self.board).of_core()

    def verdict(self, blocks):
        """Return error and pixel that the board gives, None if it takes the line."""
        first = self.board.axis(0)["next_block"]
        try:
            for number, block in enumerate(blocks):
                self.board.write_block(0, first + number, block)
        except BoardError as error:
            assert error.code != BUSY
            assert regs.axis_state(self.board.axis(0)["axis_state"]) == "refused"
            refusal = self.board.refusal(0)
            return refusal.name, refusal.pixel
        finally:
            self.forget()
            self.board.write_setting("divider", 1)
        return None

    def forget(self):
        """Discard what is queued."""
        self.board.command("discard", [0])
        self.bench.until(lambda: self.bench.state() == "empty")

    def of_host(self, queued):
        """Return error and pixel that the host gives."""
        bounds = self.limits
        if queued[0][0] & MARK_DIVIDER:
            ticks = period_ticks(self.world.hz, self.bench.sim.tick_hz) * max(queued[2][0], 1)
            bounds = replace(bounds, pixel_ticks=int(ticks))
        errors = [code for code in core.check(queued, bounds) if code.is_error]
        found = (errors[0].name, errors[0].pixel) if errors else None
        rest = (queued[0][0] & ~MARK_DIVIDER, *queued[0][1:])
        marked = core.check([rest, *queued[1:2]], bounds)
        refused = any(code.is_error and code.name == "malformed" for code in marked)
        if queued[0][0] & MARK_DIVIDER and not refused and not self.board.has("line_divider"):
            found = ("not_built", 1)
        self.seen[found and found[0]] += 1
        return found

    def moving(self, queued):
        """Return what the board says of a line that begins to move before it is all there."""
        upload = LineUpload(self.board, 0, queued)
        try:
            upload.push()
            self.board.command("arm", [0])
            while not upload.done:
                upload.push()
                self.bench.sim.wait_s(0.002)
        except LineRefusedByBoardError as error:
            assert self.bench.state() in ("armed", "running")
            return error.name, error.pixel
        finally:
            self.rest()
        return None

    def rest(self):
        """Stop, and clear the fault of a line that ran dry."""
        self.board.command("stop", [0])
        self.bench.sim.wait_s(SETTLE_S)
        if self.bench.fault() != "none":
            self.board.command("clear_fault", [0])
        self.forget()


@pytest.fixture(params=BOARDS)
def judge(request):
    """Return a judge of each board."""
    with Bench(request.param) as bench:
        yield Judge(bench)


def try_lines(count, strategy, test):
    """Try so many lines, the same ones in every run."""
    settings(
        max_examples=count, deadline=None, derandomize=True, database=None,
        suppress_health_check=list(HealthCheck),
    )(given(strategy)(test))()  # fmt: skip


def test_host_and_board_judge_alike(judge, lines_option):
    count = max(FEWEST, lines_option)

    def agree(case):
        world, queued, blocks = case
        judge.settle_in(world)
        host = judge.of_host(queued)
        assert judge.verdict([queued]) == host
        assert judge.verdict(blocks) == host

    def with_blocks(world):
        return entries().flatmap(
            lambda queued: st.tuples(st.just(world), st.just(queued), pieces(queued))
        )

    try_lines(count, WORLDS.flatmap(with_blocks), agree)
    assert judge.seen[None] > count // 20, judge.seen
    assert len(judge.seen) > 9, judge.seen


def test_host_and_moving_board_judge_alike(judge, lines_option):
    judge.settle_in(World(Fraction(250), 20, 0, 0))
    count = max(FEWEST, lines_option) // MOVING

    def agree(queued):
        assert judge.moving(queued) == judge.of_host(queued)

    try_lines(count, long_lines(), agree)
    assert judge.seen[None] and len(judge.seen) > 2, judge.seen


def test_a_reversal_too_fast_for_the_board_is_refused_on_the_host(judge):
    judge.settle_in(World(Fraction(10013, 100), 20, 0, 0))
    queued = queue_entries(Line((1, 1, 1, -118, -118, -1), PLAIN))
    host = judge.of_host(queued)
    assert judge.verdict([queued]) == host
    large = judge.limits.reversal_min_ticks > judge.limits.pixel_ticks // 118
    assert host == (("reversal_too_fast", 4) if large else None)
