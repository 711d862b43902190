# SPDX-License-Identifier: MIT
"""A line reaches the queue of one axis, or of one board's axes, too late by a random time.

All axes end at the same line, by the edges on their pins, or the run ends with a fault that names
the motor. Nothing in between is right.
"""

from __future__ import annotations

import contextlib
import random
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.jobs import run_log, sender
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimLink
from pixstep_dev.jobs import passes
from pixstep_dev.jobs.press import PLACES, Press

_MOST_LINES = 2.5  # a line is late by so many lines' time at most
_WHICH = {  # whose line is late: of one motor, of a board's, of all
    "M39": ("M39",), "M40": ("M40",), "M41": ("M41",), "main": ("M39", "M40"),
    "all": ("M39", "M40", "M41"),
}  # fmt: skip


@dataclass(frozen=True)
class LatePlan:
    """How many lines are late, each in a job of so many lines."""

    times: int = 10
    lines: int = 4
    seed: int = 1


@dataclass
class LateOutcome:
    """How runs have ended: finished, finished with a rest of all axes, or by a named fault."""

    times: int = 0
    ends: dict[str, int] = field(default_factory=dict)
    complaints: list[str] = field(default_factory=list)


def run(plan: LatePlan, show: Progress = unseen) -> LateOutcome:
    """Let lines be late."""
    outcome, chance, ends = LateOutcome(), random.Random(plan.seed), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        press = Press.make(Path(folder), plan.lines)
        for number in range(plan.times):
            outcome.times += 1
            ends[_one(press, Path(folder) / f"{number}.pxrun", chance, outcome)] += 1
            show((number + 1) / plan.times)
    outcome.ends = dict(ends)
    return outcome


def _one(press: Press, where: Path, chance: random.Random, outcome: LateOutcome) -> str:
    """Let one line be late; return how the run has ended."""
    line, which = chance.randint(2, press.job.lines), chance.choice([*_WHICH])
    late_s = chance.random() * _MOST_LINES * press.job.pixels / float(press.job.pixel_hz)
    name = f"{outcome.times}: line {line} of {which}, {late_s:.3f} s"
    held = {(PLACES[motor][0] + 1, PLACES[motor][1]) for motor in _WHICH[which]}
    with press.bus(seed=chance.randrange(1 << 31)) as link:
        try:
            with _late(link, line, held, late_s):
                press.run(link, where)
            error = ""
        except BoardError as raised:
            error = str(raised)
        ended = {name: _lines_made(link, *place) for name, place in PLACES.items()}
        link.simulator.quit()
    events = run_log.read(where / run_log.NAME)
    if error:
        if "too late" not in error or not any(motor in error for motor in PLACES):
            outcome.complaints.append(f"{name}: the fault names no motor: {error}")
        if events[-1]["event"] != "stopped":
            outcome.complaints.append(f"{name}: the log ends with {events[-1]}")
        return "named fault"
    for motor, lines in ended.items():
        if lines != press.job.lines:
            outcome.complaints.append(f"{name}: {motor} made {lines} lines, and nobody said so")
    _judge(press, name, outcome)
    chains = sum(one["event"] == "chain" for one in events)
    return "in time" if chains == 1 else "all rested together"


def _lines_made(link: SimLink, board: int, axis: int) -> int:
    """Return how many lines an axis has made since reset, by its own count."""
    return link.board(board + 1).axis(axis)["lines_done"]


def _judge(press: Press, name: str, outcome: LateOutcome) -> None:
    """Judge that each line was printed once, and all motors are where they end."""
    made = passes.of(press)
    wrong = [line for line in range(1, press.job.lines + 1) if made.full[line] != 1]
    if wrong:
        outcome.complaints.append(f"{name}: lines {wrong} were not printed once, and nobody said")
    for motor, steps in made.made.items():
        lines = range(1, press.job.lines + 1)
        whole = sum(press.steps(line, motor) for line in lines)
        if steps != whole:
            outcome.complaints.append(f"{name}: {motor} made {steps} steps, not {whole}")
    for motor, steps in made.ends.items():
        wanted = press.job.expected(press.job.lines, motor)[-1]
        if steps != wanted:
            outcome.complaints.append(f"{name}: {motor} ended at {steps}, not {wanted}")


@contextlib.contextmanager
def _late(link: SimLink, line: int, held: set[tuple[int, int]], late_s: float) -> Iterator[None]:
    """Let a line of some axes wait before its first block."""
    counts: Counter[tuple[int, int]] = Counter()

    class Late(LineUpload):
        """An upload that may have to wait."""

        def __init__(self, board: Any, axis: int, *more: Any) -> None:
            super().__init__(board, axis, *more)
            place = (board.unit, axis)
            counts[place] += 1
            waits = place in held and counts[place] == line
            self._from_s = link.world.now_s() + (late_s if waits else 0.0)

        def push_into(self, room: int) -> int:
            """Send a block, if it is time."""
            return super().push_into(room) if link.world.now_s() >= self._from_s else 0

    with mock.patch.object(sender, "LineUpload", Late):
        yield
