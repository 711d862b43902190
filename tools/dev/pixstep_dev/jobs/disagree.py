# SPDX-License-Identifier: MIT
"""Two boards of a job that say different things of it: nothing moves, and a row a board says what.

A job is paused, or its host dies, and one board is made to differ: it made a line alone, was moved
or homed by others, was reset, has another tag, or its positions are others. Resume has to refuse,
by the edges on the pins; and to print the rest once it is told how.
"""

from __future__ import annotations

import contextlib
import random
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

from pixstep import ops
from pixstep.board import run as board_run
from pixstep.board.errors import BoardError
from pixstep.board.run import LinesOfBoard
from pixstep.board.upload import LineUpload
from pixstep.jobs import sender, stations
from pixstep.jobs.run_folder import RunFolder
from pixstep.operations.result import Result
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimLink
from pixstep_dev.jobs import passes, power
from pixstep_dev.jobs.press import PLACES, Press

NAMES = ("main", "side")
_REFUSED = 3
_GONE_S = 0.05  # that a request without an answer takes
_MOVED = {0: ("M40", "move.csv"), 1: ("M41", "step.csv")}  # what others move, by board


@dataclass(frozen=True)
class DisagreePlan:
    """How often boards disagree, in jobs of so many lines."""

    times: int = 10
    lines: int = 6
    seed: int = 1


@dataclass
class DisagreeOutcome:
    """What was found."""

    times: int = 0
    kinds: dict[str, int] = field(default_factory=dict)
    together: int = 0
    homed: int = 0
    chains: int = 0
    worst_start_steps: int = 0
    complaints: list[str] = field(default_factory=list)


def run(plan: DisagreePlan, show: Progress = unseen) -> DisagreeOutcome:
    """Let boards disagree `times` times."""
    outcome, chance = DisagreeOutcome(), random.Random(plan.seed)
    with tempfile.TemporaryDirectory() as folder:
        press = Press.make(Path(folder), plan.lines, starts=power.STARTS)
        press.options["plants"] = power.plants()
        for number in range(plan.times):
            kind = [*_KINDS][number % len(_KINDS)]
            outcome.times += 1
            outcome.kinds[kind] = outcome.kinds.get(kind, 0) + 1
            _DisagreeTrial(press, Path(folder) / f"{number}.pxrun", kind, chance, outcome).make()
            show((number + 1) / plan.times)
    return outcome


@dataclass
class _DisagreeTrial:
    """One job whose boards disagree."""

    press: Press
    where: Path
    kind: str
    chance: random.Random
    outcome: DisagreeOutcome
    board: int = 0

    def make(self) -> None:
        """Print a part, let a board differ, resume."""
        self.board = self.chance.randrange(2)
        with (
            self.press.bus(seed=self.chance.randrange(1 << 31)) as link,
            power.starts(self.press, link) as begun,
        ):
            power.home(self.press, link)
            try:
                _KINDS[self.kind](self, link)
                found = self._refused(link)
                asked = self._go_on(link, found) if found else []
            except BoardError as error:
                self._complain(f"{error}")
                return
            power.judge_starts(begun, self._name, self.outcome)
            link.simulator.quit()
        self._judge_passes(asked)

    @property
    def _name(self) -> str:
        return f"{self.outcome.times}, {self.kind}, board {NAMES[self.board]}"

    def _complain(self, text: str) -> None:
        self.outcome.complaints.append(f"{self._name}: {text}")

    def _print_until_pause(self, link: SimLink) -> None:
        """Print until a pause at the end of some line before the last one."""
        line_s = self.press.job.pixels / float(self.press.job.pixel_hz)
        for_s = self.chance.random() * line_s * (self.press.job.lines - 3)
        with _paused_after(link, for_s):
            done = self.press.run(link, self.where, to_start=True)
        if done["state"] != "paused":
            self._complain(f"is {done['state']}, not paused")

    def by_a_line(self, link: SimLink) -> None:
        """Let the first board make a line alone: its host dies before the other board has it.

        The other way round there is no such line: no board gets any of it before the first one has.
        """
        self.board = 0
        line = self.chance.randint(3, self.press.job.lines - 1)
        with _dies_with(link, line, 1 - self.board), contextlib.suppress(BoardError):
            self.press.run(link, self.where, to_start=True)
        link.world.wait(3 * self.press.job.pixels / float(self.press.job.pixel_hz))

    def by_counters(self, link: SimLink) -> None:
        """Let others move a motor of one board there and back again."""
        self._print_until_pause(link)
        motor, profile = _MOVED[self.board]
        for steps in (40, -40):
            ops.board_move(
                self.press.folder / profile, steps=steps, unit=self.board + 1,
                axis=PLACES[motor][1], link=link, machine=self.press.machine, motor=motor,
            )  # fmt: skip

    def by_a_tag(self, link: SimLink) -> None:
        """Let others give one board another tag."""
        self._print_until_pause(link)
        board = link.board(self.board + 1)
        stations.hold(board, stations.TAG, board.setting(stations.TAG) % 0xFFFF + 1)

    def by_a_reset(self, link: SimLink) -> None:
        """Reset one board while the run is paused."""
        self._print_until_pause(link)
        link.simulator.reset(self.board)
        link.world.wait(1.0)

    def by_homing(self, link: SimLink) -> None:
        """Let others home a motor of one board again, which leaves it at its switch."""
        self._print_until_pause(link)
        motor, _ = _MOVED[self.board]
        ops.board_home(
            profile=self.press.folder / f"home-{motor}.csv", decode="plain", unit=self.board + 1,
            machine=self.press.machine, motor=motor, link=link,
        )  # fmt: skip

    def by_positions(self, link: SimLink) -> None:
        """Let one board's positions be read as others, with the counters of the run."""
        self._print_until_pause(link)

    def _refused(self, link: SimLink) -> Result | None:
        """Judge that resume refuses, moves nothing, and has a row a board; None if it goes on."""
        before = self._made(link)
        with _shifted(self.board) if self.kind == "positions" else contextlib.nullcontext():
            found: Result = self.press.resume(link, self.where)
        link.world.wait(0.5)
        if self._made(link) != before:
            self._complain(f"something moved: {before}, {self._made(link)}")
        if found.status != _REFUSED or found["state"] != "undecided":
            self._complain(f"went on: {found.page()}")
            return None
        rows = {one["board"]: one for one in found["boards"]}
        page = found.page()
        if [*rows] != [*NAMES] or any(f"board {name}: {rows[name]['text']}" not in page
                                      for name in NAMES):  # fmt: skip
            self._complain(f"not a row a board: {page}")
        if not page.endswith("nothing has moved"):
            self._complain(f"does not say that nothing moved: {page}")
        self._judge_rows(rows, page)
        return found

    def _judge_rows(self, rows: dict[str, Any], page: str) -> None:
        """Judge which board is said to differ, and what would help."""
        mine, other = NAMES[self.board], NAMES[1 - self.board]
        if self.kind == "a line alone":
            if "made different lines: together goes on" not in page or "redo" not in page:
                self._complain(f"does not say what would help: {page}")
            if not (rows[mine]["trusted"] and rows[other]["trusted"]):
                self._complain(f"positions are not trusted: {rows}")
            if rows[mine]["text"] == rows[other]["text"]:
                self._complain(f"the boards say the same: {rows}")
            return
        motors = [name for name, place in PLACES.items() if place[0] == self.board]
        if rows[mine]["trusted"] or not rows[other]["trusted"]:
            self._complain(f"another board is trusted: {rows}")
        if f"positions do not hold: {', '.join(motors)}: home them" not in page:
            self._complain(f"does not say what to home: {page}")

    def _go_on(self, link: SimLink, found: Result) -> list[int]:
        """Answer what is asked, and print the rest; return the lines that were asked about."""
        asked = [one["line"] for one in found["in_flight"] if one["fate"] in ("broken", "unknown")]
        homed = not all(one["trusted"] for one in found["boards"])
        if self.kind == "a line alone":
            before = self._made(link)
            still = self.press.resume(link, self.where, redo=tuple(asked))
            if still.status != _REFUSED or self._made(link) != before:
                self._complain(f"went on without --together: {still.page()}")
        if homed:
            power.home(self.press, link)
            self.outcome.homed += 1
        done: Result = self.press.resume(
            link, self.where, redo=tuple(asked), homed=homed, together=not homed
        )
        self.outcome.together += not homed
        if done["state"] != "finished":
            self._complain(done.page())
        return asked

    def _made(self, link: SimLink) -> list[int]:
        """Return how many STEP edges each motor has made."""
        return [link.simulator.count(*place) for place in PLACES.values()]

    def _judge_passes(self, asked: list[int]) -> None:
        """Judge that each line was printed once; one that was made alone and asked about, twice."""
        start = power.HOMES["M41"] + power.STARTS["M41"]
        full = passes.of(self.press, start).full
        for line in range(1, self.press.job.lines + 1):
            most = 2 if line in asked else 1
            if not 1 <= full[line] <= most:
                self._complain(f"line {line} was printed {full[line]} times, asked about {asked}")


_KINDS: dict[str, Callable[[_DisagreeTrial, SimLink], None]] = {
    "a line alone": _DisagreeTrial.by_a_line,
    "counters": _DisagreeTrial.by_counters,
    "a tag": _DisagreeTrial.by_a_tag,
    "a reset": _DisagreeTrial.by_a_reset,
    "homed by others": _DisagreeTrial.by_homing,
    "positions": _DisagreeTrial.by_positions,
}


@contextlib.contextmanager
def _paused_after(link: SimLink, seconds: float) -> Iterator[None]:
    """Let somebody ask for a pause, so long after a first line has been queued."""
    from_s: list[float] = []

    def asked(folder: RunFolder) -> bool:
        if not from_s and any(one["event"] == "queued" for one in folder.events()):
            from_s.append(link.world.now_s())
        return bool(from_s) and link.world.now_s() >= from_s[0] + seconds

    with mock.patch.object(RunFolder, "pause_asked", property(asked)):
        yield


@contextlib.contextmanager
def _shifted(board: int) -> Iterator[None]:
    """Let the positions of a board be read 7 steps further; all else is as the board says it."""
    real = board_run.look

    def look(lines: LinesOfBoard) -> Any:
        found = real(lines)
        if lines.board.unit == board + 1:
            lines.seen = {
                axis: {**seen, "position_steps": seen["position_steps"] + 7}
                for axis, seen in lines.seen.items()
            }
        return found

    with mock.patch.object(board_run, "look", look):
        yield


@contextlib.contextmanager
def _dies_with(link: SimLink, line: int, board: int) -> Iterator[None]:
    """Let the host die when a line is on one board and not yet on the other, `board`."""
    transmit, gone_s = link.modbus._transmit, [float("inf")]
    counts: dict[tuple[int, int], int] = {}

    class Held(LineUpload):
        """An upload that a dying host does not make."""

        def __init__(self, board_: Any, axis: int, *more: Any) -> None:
            super().__init__(board_, axis, *more)
            place = (board_.unit, axis)
            counts[place] = counts.get(place, 0) + 1
            self._is_held = place[0] == board + 1 and counts[place] == line

        def push_into(self, room: int) -> int:
            """Send a block, unless this is the line that does not come."""
            if not self._is_held:
                return super().push_into(room)
            gone_s[0] = min(gone_s[0], link.world.now_s() + 2 * _GONE_S)
            return 0

    def cut(frame: bytes) -> bytes:
        if link.world.now_s() < gone_s[0]:
            return transmit(frame)
        link.world.wait(_GONE_S)
        return b""

    with mock.patch.object(sender, "LineUpload", Held), mock.patch.object(
        link.modbus, "_transmit", cut
    ):  # fmt: skip
        yield
