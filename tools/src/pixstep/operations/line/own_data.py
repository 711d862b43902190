# SPDX-License-Identifier: MIT
"""Make a line of a user's own table of numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypedDict

from pixstep import atomic, formats, owndata
from pixstep.formats.findings import counted
from pixstep.lines import line_check
from pixstep.lines.line import SMOOTH
from pixstep.lines.line_check import FindingFacts
from pixstep.operations import machine_defaults as machine
from pixstep.operations import shared
from pixstep.operations.asked import AskedRefusedError
from pixstep.operations.clocks import OfClock
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, OUTPUT, TEXT, Choice, Text, Whole
from pixstep.operations.request import argument, flag, operation, option
from pixstep.operations.result import Result
from pixstep.owndata.columns import QUANTITIES
from pixstep.owndata.table import BLANK, DECIMALS, NONE, SEPARATORS
from pixstep.profiles import origin


class _Column(Text):
    """The name of a column, or its number."""

    python = "str | int"

    def judge(self, value: Any) -> str:
        """Return a number as a text."""
        return str(Whole(1).judge(value))


class ImportedLine(TypedDict):
    """A line that was made of a table, what was assumed, and how far it is from its numbers."""

    file: str
    output: str | None
    decode: str
    negative: bool
    pixels: int
    steps: int
    largest_error_steps: float
    assumed: list[str]
    findings: list[FindingFacts]


@operation("line import")
class LineImport(OfClock):
    """Make a line of your own table: what a spreadsheet exports, or what numpy's savetxt writes.

    One row a pixel (positions: one more, the start). Lengths need a motor of the machine file. What
    was assumed is printed; a table that can be read in two ways, or a line that the motor cannot
    make, is refused and not written.
    """

    result = ImportedLine

    table: Path = argument(FILE, shown="FILE")
    decode: str = shared.decode()
    column: str | None = option(_Column(), "Column to take, if there are several.", shown="NAME|N")
    quantity: str | None = option(
        Choice(QUANTITIES), "What it holds for each pixel.",
        default_text="by the header; whole numbers: steps",
    )  # fmt: skip
    length_unit: str | None = option(
        TEXT, "steps, mm, um, deg ...; of speeds also mm/s or um/px.", "--unit", shown="UNIT",
        default_text="by the header",
    )  # fmt: skip
    separator: str | None = option(
        Choice((*SEPARATORS, BLANK, NONE)), "What divides the fields.", default_text="by the file"
    )
    decimal: str | None = option(
        Choice(tuple(DECIMALS)), "What divides the decimals; the other one thousands.",
        default_text="by the file",
    )  # fmt: skip
    needs_clock = False  # only for speeds per second, and to check times

    negative: bool | None = flag(
        "Turn the direction round.", off="--no-negative", default=None,
        machine=machine.negative_of_motor,
    )  # fmt: skip
    fit: bool = flag("Smooth motors: make the nearest line that they can.")
    output: Path = option(OUTPUT, "CSV file to write.", "-o", "--output", required=True)

    def run(self, desk: Desk) -> Result:
        """Read the table, make the line and write it."""
        hz = self.pixel_hz
        request = owndata.ImportRequest(
            self.decode, hz, self.quantity, self.length_unit, self.column, desk.facts.scale(),
            negative=bool(self.negative), fit=self.fit,
            separator=self.separator, decimal=self.decimal,
        )  # fmt: skip
        made = owndata.import_line(self.table, request)
        line = made.line
        wrong = next((item for item in made.findings if item.severity == line_check.ERROR), None)
        if wrong is not None:
            fits = line.decode == SMOOTH and not self.fit
            raise AskedRefusedError(
                "{where}: {why}" + " ({fit} makes the nearest line)" * fits,
                where=f"{self.table}: pixel {wrong.pixel}: {wrong.name}", why=wrong.message,
            )  # fmt: skip
        header = origin.of_pixels(self.output, 0, hz, self.edges) if hz else None
        formats.write_csv(self.output, list(line.counts), header)
        desk.say(made.assumed)
        desk.say(f"pixel {item.pixel}: {item.name}: {item.message}" for item in made.findings)
        data: ImportedLine = {
            "file": str(self.table),
            "output": None if atomic.is_stdout(self.output) else str(self.output),
            "decode": line.decode,
            "negative": line.negative,
            "pixels": line.pixels,
            "steps": line.total_steps,
            "largest_error_steps": float(made.largest_error_steps),
            "assumed": list(made.assumed),
            "findings": line_check.as_json(made.findings),
        }
        size = f"{counted(line.pixels, 'pixel')}, {counted(line.total_steps, 'step')}"
        return Result(data, f"{self.output}: {size}, {line.decode}", value=made)
