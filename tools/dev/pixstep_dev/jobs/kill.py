# SPDX-License-Identifier: MIT
"""The host dies by SIGKILL at a random instant, also in the middle of writing its log; then resume.

Each line has to be on the glass exactly once by the edges on the pins, or the tool has listed it as
broken or unknown before anything moved again.
"""

from __future__ import annotations

import contextlib
import os
import random
import signal
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from unittest import mock

from pixstep import ops
from pixstep.board.errors import BoardError
from pixstep.jobs import run_log
from pixstep.operations.result import Result
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimLink
from pixstep_dev.jobs import passes
from pixstep_dev.jobs.press import BOARDS, Press

_REFUSED = 3
_WAITS_S = 8.0  # from the host's death to the next one's start, at most
_STOPPED, _STOPS_S = 0.4, 0.8  # in how many cases somebody stops the boards then, and how soon
_TWICE = 0.3  # in how many cases the host that goes on dies too
_ENDED = 7  # exit status of a child that came to its end


@dataclass(frozen=True)
class KillPlan:
    """How often the host is killed, in jobs of so many lines."""

    times: int = 10
    lines: int = 20
    seed: int = 1


@dataclass
class KillOutcome:
    """What was found; `complaints` are lines that are not as the tool had said."""

    times: int = 0
    killed: int = 0
    killed_again: int = 0  # of these, also the host that went on
    listed: int = 0
    most_listed: int = 0
    fates: dict[str, int] = field(default_factory=dict)
    complaints: list[str] = field(default_factory=list)


def run(plan: KillPlan, show: Progress = unseen) -> KillOutcome:
    """Kill the host `times` times."""
    outcome, chance = KillOutcome(), random.Random(plan.seed)
    with tempfile.TemporaryDirectory() as folder:
        press = Press.make(Path(folder), plan.lines)
        points = _points(press, Path(folder) / "whole.pxrun")
        for number in range(plan.times):
            where = Path(folder) / f"{number}.pxrun"
            _one(press, where, chance, points, outcome)
            outcome.times += 1
            show((number + 1) / plan.times)
    return outcome


def _points(press: Press, where: Path) -> int:
    """Return how many instants there are at which a host can be killed."""
    with press.bus() as link:
        deaths = _Deaths(link, 0, 0.0)
        with _patched(deaths):
            press.run(link, where)
    return deaths.count


def _one(
    press: Press, where: Path, chance: random.Random, points: int, outcome: KillOutcome
) -> None:
    at, share = chance.randint(1, points), chance.random()
    name = f"kill {outcome.times + 1}, instant {at}"
    with press.bus(seed=chance.randrange(1 << 31)) as link:
        status = _in_child(lambda: _dying(press, link, where, at, share))
        outcome.killed += os.WIFSIGNALED(status)
        if chance.random() < _STOPPED:
            _stop_by_hand(link, chance)
        link.simulator.wait_s(chance.random() * _WAITS_S)
        if not (where / run_log.NAME).exists() or not run_log.read(where / run_log.NAME):
            outcome.fates["not begun"] = outcome.fates.get("not begun", 0) + 1
            return
        if chance.random() < _TWICE:
            seed, again = chance.random(), chance.randint(1, points)
            status = _in_child(
                lambda: _dying_again(press, link, where, random.Random(seed), again, share)
            )
            outcome.killed_again += os.WIFSIGNALED(status)
            link.simulator.wait_s(chance.random() * _WAITS_S)
        try:
            _resume(press, link, where, chance, outcome, name)
        except BoardError as error:
            outcome.complaints.append(f"{name}: resume: {error}")
            return
        link.simulator.quit()
    _judge(press, outcome, name, run_log.read(where / run_log.NAME))


def _stop_by_hand(link: SimLink, chance: random.Random) -> None:
    """Stop the boards whose host has died, as somebody beside them may."""
    link.simulator.wait_s(chance.random() * _STOPS_S)
    for unit in (1, 2):
        ops.board_stop(units=unit, link=link)


def _dying(press: Press, link: SimLink, where: Path, at: int, share: float) -> None:
    with _patched(_Deaths(link, at, share)):
        press.run(link, where)


def _dying_again(
    press: Press, link: SimLink, where: Path, chance: random.Random, at: int, share: float
) -> None:
    with _patched(_Deaths(link, at, share)):
        _resume(press, link, where, chance, KillOutcome(), "")


def _resume(
    press: Press, link: SimLink, where: Path, chance: random.Random, outcome: KillOutcome, name: str
) -> None:
    """Go on; half of the lines that are listed first are printed again."""
    found = press.resume(link, where)
    if found.status == _REFUSED:
        listed = _listed(found, outcome)
        redone = {line for line in sorted(listed) if chance.random() < 0.5}
        homed = not all(one["trusted"] for one in found["boards"])
        for unit in range(1, len(BOARDS) + 1) if homed else ():
            ops.board_clear(units=unit, link=link)  # of what a silent bus has stopped
        found = press.resume(
            link, where, redo=tuple(sorted(redone)), skip=tuple(sorted(listed - redone)),
            homed=homed, together=True,
        )  # fmt: skip
    if found["state"] != "finished":
        outcome.complaints.append(f"{name}: {found['state']}: {found.page()}")


def _listed(found: Result, outcome: KillOutcome) -> set[int]:
    listed = {one["line"] for one in found["in_flight"] if one["fate"] in ("broken", "unknown")}
    for one in found["in_flight"]:
        outcome.fates[one["fate"]] = outcome.fates.get(one["fate"], 0) + 1
    outcome.listed += len(listed)
    outcome.most_listed = max(outcome.most_listed, len(listed))
    return listed


def _judge(press: Press, outcome: KillOutcome, name: str, events: list[dict[str, Any]]) -> None:
    """Judge each line by its edges and by what the log says was decided before anything moved."""
    made = passes.of(press)
    asked = [
        one for one in events
        if one["event"] == "skip"
        or (one["event"] == "redo" and one["was"].startswith(("broken", "unknown")))
    ]  # fmt: skip
    listed = {one["line"] for one in asked}
    skipped = {one["line"] for one in asked if one["event"] == "skip"}
    for line in range(1, press.job.lines + 1):
        times = made.full[line]
        # A host that dies between two boards' go lets one of them run alone: the stepping motor
        # stands at the first listed line while the scanning motor makes all of them.
        least, most = int(line not in skipped), len(asked) + 1
        if line not in listed:
            least = most = 1
        if not least <= times <= most:
            how = "listed" if line in listed else "not listed"
            outcome.complaints.append(f"{name}: line {line}, {how}: printed {times} times")
    moved = any(one["event"] == "moved" for one in events)
    whole = sum(press.steps(line) for line in range(1, press.job.lines + 1))
    if not listed and not moved and made.edges != whole:
        outcome.complaints.append(f"{name}: {made.edges} edges, not {whole}")


class _Deaths:
    """Counts the instants at which a host may die, and kills this process at one of them.

    They are before each command to the simulator, before each write of the log, in the middle of it
    and before it is on the disk.
    """

    def __init__(self, link: SimLink, at: int, share: float) -> None:
        self.count, self._at, self._share = 0, at, share
        self.simulator = link.simulator

    def passes(self, before: Callable[[], object] = lambda: None) -> None:
        """Count an instant; at the one that was chosen do something last, and die."""
        self.count += 1
        if self.count == self._at:
            before()
            os.kill(os.getpid(), signal.SIGKILL)

    def write(self, real: Callable[[int, Any], int], handle: int, data: Any) -> int:
        """Write to the log, or a part of it at last."""
        self.passes(lambda: real(handle, data[: int(self._share * len(data))]))
        return real(handle, data)


@contextlib.contextmanager
def _patched(deaths: _Deaths) -> Iterator[None]:
    """Let this process pass its instants."""
    real_command, real_write, real_sync = deaths.simulator.command, run_log._write, run_log._sync

    def command(text: str) -> str:
        deaths.passes()
        return real_command(text)

    def write(handle: int, data: bytes) -> int:
        return deaths.write(real_write, handle, data)

    def sync(handle: int) -> None:
        deaths.passes()
        real_sync(handle)

    with (
        mock.patch.object(deaths.simulator, "command", command),
        mock.patch.object(run_log, "_write", write),
        mock.patch.object(run_log, "_sync", sync),
    ):
        yield


def _in_child(act: Callable[[], None]) -> int:
    """Do something in a process of its own; return its wait status."""
    child = os.fork()
    if child == 0:
        try:
            act()
        except BaseException:  # the parent finds what it left
            os._exit(1)
        os._exit(_ENDED)
    return os.waitpid(child, 0)[1]
