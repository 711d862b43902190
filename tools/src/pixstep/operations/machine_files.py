# SPDX-License-Identifier: MIT
"""Machine files: begin one, check it, show what it says."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypedDict

from pixstep import atomic
from pixstep.errors import FINE, NEGATIVE, REFUSED, UserError
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.units import number_text
from pixstep.machine import FILE_NAME, VARIABLE, find_file
from pixstep.operations import shared
from pixstep.operations.asked import AskedError, MissingError
from pixstep.operations.clocks import refuse_both
from pixstep.operations.desk import Desk, Source
from pixstep.operations.kinds import OUTPUT, TEXT
from pixstep.operations.request import Request, argument, fields, operation, option, shared_fields
from pixstep.operations.result import Page, Result
from pixstep.simulation.report import new_table

if TYPE_CHECKING:
    import rich.table

    from pixstep.machine.files import MachineFile
    from pixstep.machine.model import ClockTable


_KINDS = (SMOOTH, PLAIN)
_USUAL = ("M39:smooth",)


class NewMachine(TypedDict):
    """The file that was begun."""

    machine: str


@operation("machine new")
class MachineNew(Request):
    """Begin a machine file: valid as it is, with a comment for every key."""

    result = NewMachine

    board: str = option(shared.BOARD, "Kind of the board.", required=True)
    clock_hz: Fraction | None = shared.clock_hz(machine=None)
    pixel_hz: Fraction | None = shared.hz_of_pixels()
    divider: int | None = shared.divider(machine=None, default_text="1")
    sync: str | None = shared.sync(
        "How lines follow the pixel clock.", machine=None, default=None, default_text="start"
    )
    motors: tuple[str, ...] = option(
        TEXT, "A motor, as M39:smooth or M40:plain; again for more.", "--motor", many=True,
        shown="NAME:KIND", default_text=_USUAL[0],
    )  # fmt: skip
    output: Path = option(OUTPUT, "File to write.", "-o", "--output", default=Path(FILE_NAME))

    @classmethod
    def complete(cls, values: dict[str, Any], sources: dict[str, Source]) -> None:
        """Find the frequency of the clock; the divider that does for it is found later."""
        refuse_both(values, sources)
        clock_hz, pixel_hz = values["clock_hz"], values["pixel_hz"]
        if clock_hz is None and pixel_hz is None:
            raise MissingError(fields(cls)["pixel_hz"])
        values["clock_hz"] = clock_hz or pixel_hz * (values["divider"] or 1)

    def run(self, desk: Desk) -> Result:
        """Write the file."""
        del desk
        from pixstep.machine import files  # pydantic takes a while to load

        assert self.clock_hz is not None
        kinds = _kinds(self.motors or _USUAL)
        made = files.new_text(self.board, self.clock_hz, kinds, self.divider, self.sync)
        atomic.write_text(self.output, made)
        text = f"{self.output}: edit it, then `pixstep machine check`"
        return Result({"machine": str(self.output)}, text)


@shared_fields
class _OfFile(Request):
    """A request about the file in force."""

    file: str | None = argument(TEXT, required=False, shown="[FILE]", variable=VARIABLE)

    @property
    def path(self) -> Path:
        """The file. Raises UserError if there is none."""
        path = find_file(self.file)
        if path is None:
            raise UserError(
                f"no {FILE_NAME} in this folder, and none named: `pixstep machine new` begins one"
            )
        return path


class CheckedMachine(TypedDict):
    """What is wrong with a machine file; the verdict is fine, warnings or refused."""

    machine: str
    verdict: str
    errors: list[str]
    warnings: list[str]
    notes: list[str]


@operation("machine check")
class MachineCheck(_OfFile):
    """Check a machine file: every mistake with its line, key and value.

    Exit status 0 fine, 1 warnings (what a board cannot do), 3 refused. Profiles that are not there
    yet are noted: they are made with the machine file's help.
    """

    result = CheckedMachine

    def run(self, desk: Desk) -> Result:
        """Check the file."""
        path = self.path
        from pixstep.machine import describe, files

        errors, warnings, notes = list(files.problems(path)), [], []
        if not errors:
            found = files.MachineFile.load(path)
            warnings, notes = list(describe.warnings(found)), list(describe.notes(found))
        verdict, status = ("warnings", NEGATIVE) if warnings else ("fine", FINE)
        if errors:
            verdict, status = "refused", REFUSED

        def write(page: Page) -> None:
            for text in [*errors, *(f"{path}: warning: {one}" for one in warnings)]:
                page.tell(text)
            desk.say(f"{path}: {one}" for one in notes)
            page.tell(f"{path}: {verdict}")

        data: CheckedMachine = {
            "machine": str(path), "verdict": verdict,
            "errors": errors, "warnings": warnings, "notes": notes,
        }  # fmt: skip
        return Result(data, write, status)


class ShownMachine(TypedDict):
    """What a machine file says: lengths in steps, limits per pixel and per second."""

    machine: str
    pixel_hz: str
    clock_hz: str
    divider: int | None
    sync: str | None
    gate_edges: int | None
    line: dict[str, Any]
    program: dict[str, Any]
    epics: dict[str, Any]
    boards: dict[str, dict[str, Any]]
    motors: dict[str, dict[str, Any]]


@operation("machine show")
class MachineShow(_OfFile):
    """Show the machine in force: its file, clock, boards and motors, in steps and pixels."""

    result = ShownMachine

    def run(self, desk: Desk) -> Result:
        """Read the file."""
        del desk
        from pixstep.machine import describe, files

        found = files.MachineFile.load(self.path)

        def write(page: Page) -> None:
            page.tell(
                f"{found.path}: {_clock_text(found.clock)}, lines for "
                f"{found.line.motor or ', '.join(found.motors)}"
            )
            page.draw(_boards_table(found))
            page.draw(_motors_table(found))
            page.tell("play: steps; speed, accel: limits in steps/px and steps/px2")

        return Result(describe.as_json(found), write)


def _clock_text(clock: ClockTable) -> str:
    """Return the clock, and what pixels and lines are to it where the file says so."""
    text = f"{float(clock.pixel):.10g} Hz"
    if clock.edges > 1:
        text += f", {clock.edges} clock edges a pixel"
    said = {"free": "free of the clock", "start": "on its edge", "lock": "locked to it"}
    if clock.gate_edges:
        text += f", gated: line zero {clock.gate_edges} edges after a burst's first"
    return text + (f", lines {said[clock.sync]}" if clock.sync else "")


def _kinds(texts: tuple[str, ...]) -> dict[str, str]:
    """Return the kinds of motors by name."""
    kinds: dict[str, str] = {}
    for text in texts:
        name, colon, kind = text.rpartition(":")
        if not colon or kind not in _KINDS or not name.strip() or not name.isprintable():
            raise AskedError(
                "{motors} {text}: expected NAME:KIND, as M39:smooth or M40:plain", text=text
            )
        if name in kinds:
            raise AskedError("{motors} {text}: {name} is there already", text=text, name=name)
        kinds[name] = kind
    return kinds


def _boards_table(found: MachineFile) -> rich.table.Table:
    table = new_table("board", "kind", "port", "unit", "baud", "parity", "own clock, Hz")
    for name, board in found.boards.items():
        values = board.model_dump().values()
        table.add_row(name, *("-" if value is None else str(value) for value in values))
    return table


def _motors_table(found: MachineFile) -> rich.table.Table:
    """Return a row a motor; limits per pixel, as operations use them."""
    table = new_table(
        "motor", "board", "axis", "kind", "dir", "steps per", "play", "speed", "accel"
    )
    for name, motor in found.motors.items():
        scale = motor.steps_per_unit
        limits = (
            limit.per_pixel(found.pixel_hz) if limit else None
            for limit in (motor.limit("max_speed"), motor.limit("max_acceleration"))
        )
        table.add_row(
            name, found.board_name(motor), str(motor.axis), motor.kind, motor.direction,
            f"{_text(float(scale.steps_per_unit))}/{scale.length}" if scale else "-",
            str(motor.backlash_steps),
            *("-" if limit is None else _text(float(limit)) for limit in limits),
        )  # fmt: skip
    return table


def _text(value: float) -> str:
    return number_text(Fraction(value))
