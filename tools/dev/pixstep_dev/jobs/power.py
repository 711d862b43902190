# SPDX-License-Identifier: MIT
"""A board loses its supply, is reset or loses its cable in the middle of a job; then resume.

The board is named within a second, the axes of the other one end at the same line, at most two
lines are unknown, nothing moves before the motors were homed, and every line begins where it has to
and with the load at the right side of its play.
"""

from __future__ import annotations

import contextlib
import random
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol
from unittest import mock

from pixstep import ops
from pixstep.board.errors import BoardError
from pixstep.jobs import run_log, runner
from pixstep.operations.result import Result
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimLink
from pixstep_dev.jobs.press import PLACES, Press

KINDS = ("supply", "reset", "cable")
STARTS = {"M39": -9000, "M40": -700, "M41": -700}
PLAYS = {"M39": 50, "M40": 0, "M41": 0}
HOMES = {"M39": 9500, "M40": 900, "M41": 900}
_REFUSED = 3
_NAMED_S = 1.0
_MOST_UNKNOWN = 2


@dataclass(frozen=True)
class PowerPlan:
    """How often a board is lost, in jobs of so many lines."""

    times: int = 6
    lines: int = 10
    seed: int = 1


@dataclass
class PowerOutcome:
    """What was found."""

    times: int = 0
    slowest_s: float = 0.0
    unknown: int = 0
    most_unknown: int = 0
    broken: int = 0
    chains: int = 0
    worst_start_steps: int = 0
    kinds: dict[str, int] = field(default_factory=dict)
    complaints: list[str] = field(default_factory=list)


class Judged(Protocol):
    """What is found of how chains of lines begin."""

    chains: int
    worst_start_steps: int
    complaints: list[str]


@dataclass(frozen=True)
class Start:
    """Where a motor and its load are when lines begin, and where the job has the motor."""

    motor: str
    motor_steps: int
    load_steps: int
    wanted_steps: int
    side: str


def run(plan: PowerPlan, show: Progress = unseen) -> PowerOutcome:
    """Lose a board `times` times."""
    outcome, chance = PowerOutcome(), random.Random(plan.seed)
    with tempfile.TemporaryDirectory() as folder:
        press = Press.make(Path(folder), plan.lines, starts=STARTS)
        press.options["plants"] = plants()
        for number in range(plan.times):
            kind = KINDS[number % len(KINDS)]
            outcome.times += 1
            outcome.kinds[kind] = outcome.kinds.get(kind, 0) + 1
            _one(press, Path(folder) / f"{number}.pxrun", kind, chance, outcome)
            show((number + 1) / plan.times)
    return outcome


def plants() -> dict[tuple[int, int], str]:
    """Return what the motors drive: loads with a home switch, one of them with play."""
    return {
        PLACES[name]: f"home={HOMES[name]},hyst=4,play={PLAYS[name]}" for name in PLACES
    }  # fmt: skip


def _one(
    press: Press, where: Path, kind: str, chance: random.Random, outcome: PowerOutcome
) -> None:
    unit = chance.choice((1, 2))
    line_s = press.job.pixels / float(press.job.pixel_hz)
    later_s = chance.random() * line_s * (press.job.lines - 1)
    name = f"{outcome.times}, {kind} of board {unit}"
    with press.bus(seed=chance.randrange(1 << 31)) as link, starts(press, link) as begun:
        home(press, link)
        loss = _Loss(link, unit, kind)
        with loss.after(later_s):
            try:
                press.run(link, where, to_start=True)
                outcome.complaints.append(f"{name}: nothing was said")
                return
            except BoardError:
                pass
        _judge_end(where, name, loss, unit, outcome)
        loss.mend()
        try:
            _go_on(press, link, where, name, kind, outcome)
        except BoardError as error:
            outcome.complaints.append(f"{name}: after the loss: {error}")
        judge_starts(begun, name, outcome)


def _go_on(
    press: Press, link: SimLink, where: Path, name: str, kind: str, outcome: PowerOutcome
) -> None:
    """Resume: what is asked is answered, motors are homed if that is asked."""
    found = press.resume(link, where)
    _judge_asked(found, name, kind, outcome)
    if found.status == _REFUSED:
        lines = tuple(
            one["line"] for one in found["in_flight"] if one["fate"] in ("broken", "unknown")
        )
        homed = not all(one["trusted"] for one in found["boards"])
        if homed:
            home(press, link)
        found = press.resume(link, where, redo=lines, homed=homed, together=True)
    if found["state"] != "finished":
        outcome.complaints.append(f"{name}: {found.page()}")


def _judge_end(where: Path, name: str, loss: _Loss, unit: int, outcome: PowerOutcome) -> None:
    """Judge when the loss was named, and where the others have ended."""
    events = run_log.read(where / run_log.NAME)
    lost = [one for one in events if one["event"] == "lost"]
    if not lost:
        outcome.complaints.append(f"{name}: not in the log: {events[-1]}")
        return
    outcome.slowest_s = max(outcome.slowest_s, lost[0]["s"] - loss.at_s)
    if lost[0]["s"] - loss.at_s > _NAMED_S:
        outcome.complaints.append(f"{name}: named {lost[0]['s'] - loss.at_s:.2f} s later")
    board = ("main", "side")[unit - 1]
    if lost[0]["board"] != board:
        outcome.complaints.append(f"{name}: board {lost[0]['board']} was named")
    others = [one for one in events[-1]["motors"] if one["board"] != board]
    ends = {(one.get("line"), one.get("pixel")) for one in others}
    last = lost[0]["last"]  # or the line before, if the lost board kept the bus until it was late
    if ends not in ({(last + 1, 0)}, {(last, 0)}):
        outcome.complaints.append(f"{name}: the others ended at {ends}, not line {last}")


def _judge_asked(found: Result, name: str, kind: str, outcome: PowerOutcome) -> None:
    """Judge what is asked before anything moves."""
    fates = [one["fate"] for one in found.data.get("in_flight", [])]
    unknown = fates.count("unknown")
    outcome.unknown += unknown
    outcome.broken += fates.count("broken")
    outcome.most_unknown = max(outcome.most_unknown, unknown)
    if unknown > _MOST_UNKNOWN:
        outcome.complaints.append(f"{name}: {unknown} lines are unknown")
    if kind != "cable" and found.status != _REFUSED:
        outcome.complaints.append(f"{name}: went on without homing")


def judge_starts(begun: list[Start], name: str, outcome: Judged) -> None:
    """Judge where motors and loads were when lines began: with the play on its right side."""
    for one in begun:
        home_at, play = HOMES[one.motor], PLAYS[one.motor]
        off = abs(one.motor_steps - home_at - one.wanted_steps)
        load = one.motor_steps if one.side == "+" else one.motor_steps + play
        if play:
            off = max(off, abs(one.load_steps - load))
        outcome.worst_start_steps = max(outcome.worst_start_steps, off)
        if off > 1:
            outcome.complaints.append(f"{name}: a chain begins {off} steps off: {one}")
    outcome.chains += len(begun) // len(PLACES)


def home(press: Press, link: SimLink) -> None:
    """Home all motors, as somebody beside the machine does."""
    for name, (board, _axis) in PLACES.items():
        ops.board_clear(units=board + 1, link=link)
        ops.board_home(
            profile=press.folder / f"home-{name}.csv", decode="plain", unit=board + 1,
            machine=press.machine, motor=name, link=link,
        )  # fmt: skip


@contextlib.contextmanager
def starts(press: Press, link: SimLink) -> Iterator[list[Start]]:
    """Yield what notes where motors and loads are whenever lines begin."""
    found: list[Start] = []
    real = runner.Chain._start

    def start(chain: runner.Chain) -> Any:
        runs = press.job.runs_of(chain.first)
        for name, place in PLACES.items():
            motor, load = link.simulator.plant(*place)
            found.append(Start(name, motor, load, runs[name].start_steps, runs[name].play_side))
        return real(chain)

    with mock.patch.object(runner.Chain, "_start", start):
        yield found


class _Loss:
    """A board that is lost, some time after the first line began."""

    def __init__(self, link: SimLink, unit: int, kind: str) -> None:
        self._link, self._unit, self._kind = link, unit, kind
        self.at_s = float("inf")
        self._transmit: Callable[[bytes], bytes] = link.modbus._transmit
        self._cut = False

    @contextlib.contextmanager
    def after(self, seconds: float) -> Iterator[None]:
        """Let the board be lost so long after the lines begin."""
        real = runner.Chain._start

        def start(chain: runner.Chain) -> Any:
            started = real(chain)
            self._happen(self._link.world.now_s() + seconds)
            return started

        with mock.patch.object(runner.Chain, "_start", start):
            yield

    def _happen(self, at_s: float) -> None:
        simulator, board = self._link.simulator, self._unit - 1
        cycle = max(simulator.cycles(at_s), simulator.cycle + 1)
        self.at_s = cycle / simulator.tick_hz
        if self._kind == "supply":
            simulator.supply(board, "off", at=cycle)
        elif self._kind == "reset":
            simulator.reset(board, at=cycle)
        else:
            mock.patch.object(self._link.modbus, "_transmit", self._over_a_cut_cable).start()
            self._cut = True

    def _over_a_cut_cable(self, frame: bytes) -> bytes:
        if self._cut and frame[0] == self._unit and self._link.world.now_s() >= self.at_s:
            self._link.world.wait(0.05)
            return b""
        return self._transmit(frame)

    def mend(self) -> None:
        """Give the board its supply, or its cable, back."""
        self._cut = False
        if self._kind == "supply":
            self._link.simulator.supply(self._unit - 1, "on")
        self._link.world.wait(1.0)
