# SPDX-License-Identifier: MIT
"""A new board: firmware onto it, and is everything wired as it should be?"""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Protocol, TypedDict

from pixstep.board import flash, selftest, settings
from pixstep.board.flash import FirmwareImage, FlashError
from pixstep.board.selftest import FAILED, OK, SKIPPED, Person, SelfTest
from pixstep.errors import FINE, NEGATIVE, UserError
from pixstep.operations import bus, shared
from pixstep.operations.bus import ToBoard, some_axes
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, Steps, Time
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result


class FlashedBoard(TypedDict):
    """The image, the command line of avrdude, and whether it was run."""

    port: str
    board: str
    image: str
    avrdude: list[str]
    done: bool


@operation("flash")
class Flash(ToBoard):
    """Write the firmware to a board by avrdude through its boot loader, then ask what it is.

    No compiler is needed: a wheel brings the images, in a clone tools/build makes
    them. Settings stored on the board stay: --unit, --baud and
    --parity are those that it is then asked with (the boot loader has its own), or --no-ask.
    docs/FLASHING.md has the rest.
    """

    result = FlashedBoard

    board: str = shared.simulated_board()
    hex_file: Path | None = option(
        FILE, "Image to write.", "--hex", default_text="the wheel's or the build's own"
    )
    verify: bool = flag("Only compare the board's flash with the image.")
    dry_run: bool = flag("Print avrdude's command line and do nothing.")
    ask: bool = flag("Ask the board afterwards what it is.", off="--no-ask", default=True)

    def run(self, desk: Desk) -> Result:
        """Run avrdude, then ask the board."""
        image = flash.read_image(self.hex_file or flash.built_image(self.board))
        if image.board != self.board:
            raise UserError(
                f"{image.path}: an image for the {image.board}, not for the {self.board}"
            )
        words = flash.command(self.board, self.port, image.path, verify=self.verify)
        texts = []
        if self.dry_run:
            texts.append(shlex.join(words))
        else:
            self.bus.require()
            flash.run(words)
            if self.verify:
                texts.append(f"{self.port}: the flash is as in {image.path}")
            if self.ask:
                texts.append(self._asked(desk, image))
        data: FlashedBoard = {
            "port": self.port, "board": self.board, "image": str(image.path), "avrdude": words,
            "done": not self.dry_run,
        }  # fmt: skip
        return Result(data, "\n".join(texts))

    def _asked(self, desk: Desk, image: FirmwareImage) -> str:
        """Compare what the board says of itself with the image; return that in words."""
        with bus.opened(desk, self) as found:
            who = found.board(self.unit).who()
        text, wanted = (
            f"pixstep {who.board} {who.firmware}",
            f"pixstep {image.board} {image.version}",
        )
        if text != wanted:
            raise FlashError(f"{self.port}: the board says {text!r}, the image is {wanted!r}")
        return f"{self.port}: unit {self.unit} is {text}"


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

    def sees(self, check: selftest.SelftestResult) -> None:
        """Take a check that has ended."""


@operation("board selftest")
class WiringTest(ToBoard):
    """Walk through the wiring of a new board.

    Supply, clock, switches, motors, permit output, emergency stop. It asks before anything moves or
    is switched on. Exit status 0 if nothing failed; what was left out is listed.
    """

    result = SelfTested

    axes: tuple[int, ...] = some_axes()
    yes: bool = flag("Ask nothing: check only what needs nobody at the machine.")
    limit_s: float = option(
        Time("s", 1, 600), "Time to wait for a switch.", "--limit", default=30.0,
        default_text="30s",
    )  # fmt: skip
    clock_out_hz: int | None = shared.clock_out_hz()
    steps: int = option(Steps(1, 100_000), "Slow steps to turn each motor, and back.", default=200)

    def run(self, desk: Desk) -> Result:
        """Make the checks; without anybody to ask, those that need nobody."""
        person: AtTerminal | None = desk.view
        with bus.one_board(desk, self) as (found, known):
            settings.set_clock(known.board, None, clock_out_hz=self.clock_out_hz)
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


def check_text(check: selftest.SelftestResult) -> str:
    """Return a check as a line, its verdict first."""
    return f"{check.verdict:<8}{check.name}: {check.text}"
