# SPDX-License-Identifier: MIT
"""Is everything wired as it should be?"""

from __future__ import annotations

from typing import Protocol, TypedDict

from pixstep.board import selftest
from pixstep.board.selftest import FAILED, OK, SKIPPED, Person, SelfTest
from pixstep.errors import FINE, NEGATIVE
from pixstep.operations import bus
from pixstep.operations.bus import ToBoard, some_axes
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import Steps, Time
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result


class Check(TypedDict):
    """One check: its name, how it ended, what was seen."""

    name: str
    verdict: str
    text: str


class SelfTested(TypedDict):
    """The checks of a board; `passed` if none failed."""

    unit: int
    board: str
    passed: bool
    checks: list[Check]


class AtTerminal(Person, Protocol):
    """A person who is asked, and sees each check as it ends."""

    def sees(self, check: selftest.Result) -> None:
        """Take a check that has ended."""


@operation("board selftest")
class WiringTest(ToBoard):
    """Walk through the wiring of a new board.

    Supply, clock, switches, motors, permit output, emergency stop. It asks before anything moves or
    is switched on. Exit status 0 if nothing failed; what was left out is listed.
    """

    result = SelfTested

    axes: tuple[int, ...] = some_axes()
    yes: bool = flag("Ask nothing: only what needs nobody at the machine.")
    limit_s: float = option(
        Time("s", 1, 600), "Time to wait for a switch.", "--limit", default=30.0,
        default_text="30s",
    )  # fmt: skip
    steps: int = option(Steps(1, 100_000), "Slow steps to turn each motor, and back.", default=200)

    def run(self, desk: Desk) -> Result:
        """Make the checks; without anybody to ask, those that need nobody."""
        person: AtTerminal | None = desk.view
        with bus.one_board(desk, self) as (found, known):
            test = SelfTest(
                known.board, known.who, found.world, None if self.yes else person,
                known.axes(self.axes), self.limit_s, self.steps,
            )  # fmt: skip
            test.go(person.sees if person else lambda _: None)
        data = {
            "unit": self.unit, "board": known.who.board, "passed": test.passed,
            "checks": [result.as_json() for result in test.results],
        }  # fmt: skip
        counts = {
            verdict: sum(result.verdict == verdict for result in test.results)
            for verdict in (OK, FAILED, SKIPPED)
        }
        end = ", ".join(f"{count} {verdict}" for verdict, count in counts.items())
        rows = [] if person else [check_text(result) for result in test.results]
        return Result(data, "\n".join([*rows, end]), FINE if test.passed else NEGATIVE)


def check_text(check: selftest.Result) -> str:
    """Return a check as a line, its verdict first."""
    return f"{check.verdict:<8}{check.name}: {check.text}"
