# SPDX-License-Identifier: MIT
"""Repair a file for a smooth motor: counts that oscillate, illegal speeds of a profile."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TypedDict

from pixstep import formats
from pixstep.errors import UserError
from pixstep.lines.units import Quantity
from pixstep.operations import shared
from pixstep.operations.asked import AskedError
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, OUTPUT, Choice
from pixstep.operations.profile import look
from pixstep.operations.request import Request, argument, flag, operation, option
from pixstep.operations.result import Page, Result
from pixstep.profiles import generator, page, readings
from pixstep.profiles.page import ChangeFacts
from pixstep.profiles.repair import LINE, START, Repair, Wish, repair_counts, repair_speeds

_PARTS = {LINE: "a line from rest to rest", START: "an accelerating start", None: "PRN speeds"}


class RepairedFile(TypedDict):
    """A file that was written with legal values; `part` is null for the speeds of a PRN."""

    file: str
    output: str
    part: str | None
    changes: list[ChangeFacts]
    values_before: list[int]
    values: list[int]


@operation("profile repair")
class ProfileRepair(Request):
    """Repair a file for a smooth motor: counts that oscillate, or the speeds of a PRN.

    Counts keep their length: ramps take pixels from the stretches of constant speed. A PRN gets
    the nearest speeds that are even, above 0 and never fall.
    """

    result = RepairedFile

    file: Path = argument(FILE)
    max_acceleration: Quantity | None = shared.max_acceleration(
        "Largest acceleration of the new ramps, steps/px2 or steps/s2. Default: any."
    )
    part: str | None = option(
        Choice([LINE, START]),
        "A line from rest to rest, or an accelerating start that goes on at its last speed. "
        "Default: start after a profile's header, else line.",
    )
    insert: bool = flag("Insert pixels instead of taking them from the constant ones: longer.")
    raw: bool = shared.raw()
    lenient: bool = look.lenient()
    pixel_hz: Fraction | None = shared.pixel_hz(
        "Pixel frequency, for a limit per second.", required=False
    )
    output: Path = option(OUTPUT, "File to write.", "-o", "--output", required=True)

    def run(self, desk: Desk) -> Result:
        """Repair the values and write them."""
        read = readings.load(self.file, raw=self.raw, lenient=self.lenient)
        desk.say(read.notes)
        part: str | None = None
        if read.is_prn:
            self._refuse_for_prn()
            repair = repair_speeds(read.values)
            formats.write_prn(self.output, list(repair.values))
        else:
            part = self.part or (START if read.header else LINE)
            repair = self._repair(read.values, part)
            header = replace(read.header, lines=1) if read.header else None
            formats.write_csv(self.output, list(repair.values), header)
        before, after = read.values, repair.values
        data: RepairedFile = {
            "file": str(self.file),
            "output": str(self.output),
            "part": part,
            "changes": page.changes_json(repair.changes),
            "values_before": list(before),
            "values": list(after),
        }

        def write(to: Page) -> None:
            place = "entry" if part is None else "pixel"
            to.tell(f"{self.file}: read as {_PARTS[part]}")
            changes = [page.change_text(change, place) for change in repair.changes]
            for text in page.first_lines(changes) or ["nothing to repair"]:
                to.tell(f"  {text}")
            longer = len(after) != len(before)
            length = f"{len(before)} -> {len(after)}" if longer else f"{len(before)}"
            if part is None:
                to.tell(f"{self.output}: {length} entries")
            else:
                to.tell(f"{self.output}: {length} pixels, {sum(before)} -> {sum(after)} steps")

        return Result(data, write, value=repair)

    def _refuse_for_prn(self) -> None:
        """Refuse what means nothing for the speeds of a PRN."""
        for field in ("max_acceleration", "part", "insert"):
            if getattr(self, field):
                raise AskedError(
                    f"{{path}}: {{{field}}} is for counts; `profile make` keeps limits of a PRN",
                    path=self.file,
                )

    def _repair(self, counts: tuple[int, ...], part: str) -> Repair:
        """Repair counts; an error names the file."""
        wish = Wish(self._limit(), part, self.insert)
        try:
            return repair_counts(counts, wish)
        except UserError as error:
            raise UserError(f"{self.file}: {error}") from None

    def _limit(self) -> int | None:
        """Return the limit of the acceleration as an even number."""
        limit, hz = self.max_acceleration, self.pixel_hz
        if limit is None:
            return None
        return generator.legal_limit(limit.per_pixel(hz), limit.order, hz, limit)
