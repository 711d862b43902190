# SPDX-License-Identifier: MIT
"""The captured edge of a switch whose next edges come at the worst cycles of a seek.

around the capture's interrupt, which reads the edge; around a step's interrupt, which moves the
engine's account on; and around the filter's end, where the first edge counts or is forgotten.
"""

import random
from fractions import Fraction

import pytest

from bench import Bench
from effort import cases
from pixstep.board import boards
from pixstep.board.upload import LineUpload
from pixstep.simulation.logs import read_edges

pytestmark = pytest.mark.usefixtures("simulator")
HZ = Fraction(200)
SEEK, SEEK_OPEN, DOWN, END = 0x81, 0x181, (3, 0), (2, 0)
COUNTS = {1: (1,), 20: (5, 20)}  # steps/px of a slow seek and of a quick one
FILTER_US = 200
# From an edge until its interrupt has read it, at most: 40 us, with the interrupts of a step and of
# the bounces in between.
READ_TICKS = 640
ROUND_US = 900  # until the main loop has seen that the filter's time is over, at most
TRIALS = cases(12, 120)


class Seeks(Bench):
    """A board whose home switch is in the test's hand."""

    def __init__(self, board, axis, counts, edges):
        super().__init__(board, (axis,), HZ, edges)
        self.table, self.axis, self.counts = boards.load(board), axis, counts
        self.home = next(
            pin for pin in self.table.pins if pin.signal == "HOME" and pin.axis == axis
        )
        self.step_ticks = self.table.tick_hz // int(HZ) // counts[-1]

    def drive(self, level, at=None):
        self.sim.pin(0, self.home.port, self.home.bit, level, at)

    def begin(self, *, opening):
        """Have a seek under way; return the cycle of a step."""
        self.drive(0 if opening else 1)
        self.sim.wait_s(0.003)
        *up, top = self.counts
        ramp = [(count, 1) for count in up]
        down = ramp[::-1]
        word = SEEK_OPEN if opening else SEEK
        entries = [(word, 0), (0, 0), *ramp, (top, 200), DOWN, *down, END]
        upload = LineUpload(self.board, self.axis, entries)
        upload.push()
        assert upload.done
        before = self.count(self.axis)
        self.board.command("arm", [self.axis])
        self.until(lambda: self.count(self.axis) >= before + sum(up) + 2)
        return int(self.rising()[-1])

    def rising(self):
        self.sim.command("flush")
        return read_edges(self.edges_path).axis(0, self.axis).rising

    def bounce(self, cycles, *, opening):
        """Drive the switch at these cycles, to and fro; return the trip of the seek."""
        level = 1 if opening else 0
        for cycle in cycles:
            self.drive(level, at=cycle)
            level ^= 1
        self.until(lambda: self.state(self.axis) not in ("armed", "running"))
        assert self.fault() == "none"
        trip = self.board.trip()
        assert trip.code == (2 if opening else 1), trip
        return trip


def gaps(rng, step_ticks):
    """Return the times between the edges of a bouncing contact: an even number of them."""
    kind = rng.randrange(4)
    if kind == 0:  # around the interrupt that reads the edge
        longest = rng.choice((20, 80, 250))
        return [rng.randint(1, longest) for _ in range(rng.choice((2, 2, 4, 10)))]
    if kind == 1:  # faster than anything
        return [1] * rng.choice((2, 10, 60))
    if kind == 2:  # around the filter's end
        return [rng.randint(1, 250), FILTER_US * 16 + rng.randint(-2_000, ROUND_US * 16)]
    return [rng.randint(1, step_ticks // 8) for _ in range(rng.choice((2, 4, 6)))]


def place(rng, step, step_ticks, now):
    """Return the cycle of the contact's first edge: close to a step's interrupt, or anywhere."""
    behind = (now - step) // step_ticks + 2
    at = step + behind * step_ticks
    return at + rng.choice((rng.randint(-300, 300), rng.randint(0, step_ticks - 1)))


def judge(seeks, edges, trip, offset):
    """The capture is one of the contact's edges, read in time, its position that of its tick."""
    tick_hz = seeks.table.tick_hz
    base = edges[0] - READ_TICKS
    at = base + (trip.ticks + offset - base) % (1 << 32)
    assert any(edge <= at <= edge + READ_TICKS for edge in edges[::2]), (edges, at)
    # A later edge counts only where the contact was back for as long as the filter takes.
    back = [b - a for a, b in zip(edges[1::2], edges[2::2], strict=True)]
    if max(back, default=0) < FILTER_US * tick_hz // 1_000_000:
        assert at <= edges[0] + READ_TICKS, (edges, at)
    assert trip.position_steps == int((seeks.rising() <= at).sum()), (edges, at)


@pytest.mark.parametrize(
    ("board", "axis"), [("uno", 0), ("mega", 2), ("mega", 3), ("m1284", 0), ("m1284", 1)]
)
@pytest.mark.parametrize("counts", COUNTS.values(), ids=["slow", "quick"])
def test_edges_at_the_worst_cycles(tmp_path, board, axis, counts):
    rng = random.Random(f"{board} {axis} {counts}")
    with Seeks(board, axis, counts, tmp_path / "edges.csv") as seeks:
        seeks.board.write_setting("input_filter_us", FILTER_US)
        offset = None
        for number in range(TRIALS + 1):
            opening = number % 2 == 1
            step = seeks.begin(opening=opening)
            first = place(rng, step, seeks.step_ticks, seeks.sim.cycle)
            edges = [first]
            for gap in gaps(rng, seeks.step_ticks) if number else []:
                edges.append(edges[-1] + gap)
            trip = seeks.bounce(edges, opening=opening)
            if offset is None:  # from the timers' time to the simulator's cycles
                offset = (first - trip.ticks) % (1 << 32)
            judge(seeks, edges, trip, offset)
