# SPDX-License-Identifier: MIT
"""What same_edges.py runs on two images: lines, fast and poor clocks, locks, streams, stops, seeks.

A trial is a job, and what happens to it. All that comes from outside comes in the same cycle on
both images, whatever they answer.
"""

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from fractions import Fraction

from pixstep.board import boards
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.runs import Seek
from pixstep.simulation.job import LOCK, LineExperiment
from pixstep.simulation.pixel_clock import ClockFlaws
from pixstep_trials.cases import Bounds, case

FAST_HZ = (500, 750, 1000, 1600, 2000, 3000, 4000)  # of a clock of one edge a pixel
SHARED_HZ = (500, 700, 1000)  # where all axes of a board move at once
LOCK_HZ = (30, 100, 500, 1000, 2000)
SHARED_LOCK_HZ = (30, 100, 200)
MOST_HZ = 5000
STREAM_HZ = (500, 800, 1000)
STREAM_PIXELS = 1500
DIVIDERS = (1, 1, 2, 5, 16, 40)
ALONE_STEPS_S, SHARED_STEPS_S = 16_000, 6_000
MOST_PPM, MOST_JITTER_US = 5000, 3.0
SLOWEST_LINE_HZ = 10
FAST_BAUD = 500_000
HOME_STEPS = 400


@dataclass(frozen=True)
class Trial:
    """A job, and what happens to it.

    `stop_s` behind arming comes a stop by command, or by the emergency stop's contact. `seek` is
    made in the place of the job's line on its axis, towards a switch.
    """

    job: LineExperiment
    kind: str = "line"
    records: bool = False  # are read while the line is streamed
    stop_s: float = 0.0
    by_contact: bool = False
    seek: Seek | None = None
    phase: Fraction = Fraction(1, 2)  # of the clock's period, in which the lines are armed


def _lines(
    rng: random.Random, board: str, axes: int, hz: Fraction, pixels: int, decode: str
) -> dict[int, Line]:
    """Return a line for each of so many axes, which all have this pixel frequency."""
    tick_hz = boards.load(board).tick_hz
    rate = ALONE_STEPS_S if axes == 1 else SHARED_STEPS_S
    bounds = Bounds(
        min_interval_ticks=tick_hz // rate,
        min_pixels=pixels // 2,
        max_pixels=pixels,
        reversal_ticks=tick_hz // 1000,
        tick_hz=tick_hz,
    )
    return {axis: case(rng, decode, bounds, hz).line for axis in range(axes)}


def _axes(rng: random.Random, board: str) -> int:
    """Return one axis, or all that the board has."""
    return rng.choice((1, boards.load(board).axes))


def fast_clock(rng: random.Random, board: str) -> Trial:
    """Return lines that a kilohertz clock starts."""
    axes = _axes(rng, board)
    hz = Fraction(rng.choice(FAST_HZ if axes == 1 else SHARED_HZ))
    lines = _lines(rng, board, axes, hz, 100, rng.choice((SMOOTH, PLAIN)))
    return Trial(LineExperiment(board, lines, hz, baud=FAST_BAUD), "fast clock")


def locked(rng: random.Random, board: str) -> Trial:
    """Return lines that follow a clock with jitter, missing and false edges, some ppm off."""
    axes = _axes(rng, board)
    hz = Fraction(rng.choice(LOCK_HZ if axes == 1 else SHARED_LOCK_HZ))
    fitting = [divider for divider in DIVIDERS if hz / divider >= SLOWEST_LINE_HZ]
    divider = rng.choice(fitting)
    flaws = ClockFlaws(
        jitter_us=rng.choice((0.0, 0.5, MOST_JITTER_US)),
        drop=rng.choice((0, 0, 150, 400)),
        double=rng.choice((0, 0, 200, 500)),
    )
    pixels = 100 if hz / divider >= FAST_HZ[0] else 16
    lines = _lines(rng, board, axes, hz / divider, pixels, rng.choice((SMOOTH, PLAIN)))
    job = LineExperiment(
        board, lines, hz, pixel_ppm=rng.randint(-MOST_PPM, MOST_PPM), flaws=flaws, sync=LOCK,
        divider=divider, seed=rng.randint(1, 1 << 30), baud=FAST_BAUD,
    )  # fmt: skip
    return Trial(job, "lock")


def divided(rng: random.Random, board: str) -> Trial:
    """Return lines that a clock of many edges a pixel starts."""
    axes = _axes(rng, board)
    hz = Fraction(rng.choice((1000, 2000, MOST_HZ) if axes == 1 else (1000, 2000)))
    divider = rng.choice((5, 10, 50))
    lines = _lines(rng, board, axes, hz / divider, 30, rng.choice((SMOOTH, PLAIN)))
    return Trial(LineExperiment(board, lines, hz, divider=divider, baud=FAST_BAUD), "divider")


def streamed(rng: random.Random, board: str) -> Trial:
    """Return a line with a count of its own in every pixel, longer than any queue."""
    hz = Fraction(rng.choice(STREAM_HZ))
    top = int(ALONE_STEPS_S / hz)
    counts = [rng.randint(1, top)]
    while len(counts) < STREAM_PIXELS:
        counts.append(min(max(1, counts[-1] + rng.choice((-2, -1, 1, 2))), top))
    line = Line(tuple(counts), PLAIN, name="stream")
    axis = rng.randrange(boards.load(board).axes)
    return Trial(LineExperiment(board, {axis: line}, hz, baud=FAST_BAUD), "stream", records=True)


def stopped(rng: random.Random, board: str) -> Trial:
    """Return long lines that a command, or the emergency stop's contact, ends."""
    axes = _axes(rng, board)
    hz = Fraction(rng.choice((100, 500)))
    top = int((ALONE_STEPS_S if axes == 1 else SHARED_STEPS_S) / hz)
    lines = {
        axis: Line((rng.randint(1, top),) * int(hz), PLAIN, name="constant") for axis in range(axes)
    }
    return Trial(
        LineExperiment(board, lines, hz, baud=FAST_BAUD), "stop",
        stop_s=rng.uniform(0.1, 0.5), by_contact=rng.random() < 0.5,
    )  # fmt: skip


def seeking(rng: random.Random, board: str) -> Trial:
    """Return a line that seeks a home switch which bounces."""
    hz = Fraction(rng.choice((100, 500)))
    top = max(2, int(8000 / hz))
    rising = tuple(sorted(rng.randint(1, top) for _ in range(rng.randint(1, 6))))
    seek = Seek(rising, hold_px=max(1, 3 * HOME_STEPS // rising[-1]))
    axis = rng.randrange(boards.load(board).axes)
    knobs = f"home={HOME_STEPS + rng.randint(0, 99)},hyst=5,start=0,active=low"
    bounce, bounce_ticks = rng.choice((0, 2, 6)), rng.randint(1, 2000)
    knobs += f",bounce={bounce},bounce_ticks={max(bounce, bounce_ticks)}"
    stand_in = Line(rising, PLAIN, name="seek")
    job = LineExperiment(
        board, {axis: stand_in}, hz, seed=rng.randint(1, 1 << 30), plants={axis: knobs}
    )
    return Trial(replace(job, baud=FAST_BAUD), "seek", seek=seek)


KINDS: tuple[Callable[[random.Random, str], Trial], ...] = (
    fast_clock,
    locked,
    divided,
    streamed,
    stopped,
    seeking,
)


def trials(board: str, count: int, seed: int) -> Iterator[Trial]:
    """Yield so many trials of each kind; the same numbers yield the same trials."""
    for make in KINDS:
        for number in range(count):
            yield make(random.Random(f"{seed} {board} {make.__name__} {number}"), board)
