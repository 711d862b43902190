# SPDX-License-Identifier: MIT
"""Make the shortest acceleration profile within limits; repair one for a smooth motor."""

from __future__ import annotations

import time
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TypedDict

from pixstep import atomic, formats
from pixstep.errors import UserError
from pixstep.formats.header import MOST_HAPS, MOST_LEAD_IN, NAME_WIDTH, ProfileHeader
from pixstep.lines import units
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.units import ACCELERATION, JERK, SPEED, Quantity
from pixstep.operations import machine_defaults as machine
from pixstep.operations import shared
from pixstep.operations.asked import AskedError, refuse_outputs
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import (
    FILE,
    OUTPUT,
    OUTPUT_OR_FOLDER,
    SPEED_FIGURE,
    TEXT,
    Choice,
    Pixels,
    Whole,
)
from pixstep.operations.profile.look import lenient
from pixstep.operations.request import Request, argument, flag, operation, option
from pixstep.operations.result import Page, Result
from pixstep.profiles import generator, kinematics, origin, page, readings
from pixstep.profiles.page import ChangeFacts, MotionFigures
from pixstep.profiles.repair import (
    LINE,
    START,
    Repair,
    Wish,
    repair_counts,
    repair_speeds,
    whole_line,
)


class UsedLimits(TypedDict):
    """The limits that a profile keeps: even, in steps and pixels."""

    top_speed_steps_per_px: int
    max_acceleration_steps_per_px2: int
    max_jerk_steps_per_px3: int


class MadeProfile(TypedDict):
    """A profile that was written; its speeds are in steps/pixel."""

    file: str
    csv: str | None
    limits: UsedLimits
    figures: MotionFigures
    speeds: list[int]


@operation("profile make")
class ProfileMake(Request):
    """Make the shortest acceleration profile within limits of acceleration and jerk.

    All speeds are even, and the jerk limit is kept from rest up to the constant speed after the
    last entry.
    """

    result = MadeProfile
    own_motor = True

    top_speed: Quantity = option(
        SPEED_FIGURE, "Speed at the end, even: 1000, 1000steps/px or 30000steps/s.",
        required=True, machine=machine.top_speed,
    )  # fmt: skip
    max_acceleration: Quantity = shared.max_acceleration(
        "128, 128steps/px2 or 115200steps/s2.", required=True
    )
    max_jerk: Quantity = shared.max_jerk(
        "Change of the acceleration from pixel to pixel: steps/px3 or steps/s3.", required=True
    )
    pixel_hz: Fraction | None = shared.pixel_hz(
        "Pixel frequency, for figures per second and the name.", required=False
    )
    motor: str | None = option(TEXT, "Motor of the conventional name, as M39.", shown="NAME")
    variant: str | None = option(TEXT, "Variant of the conventional name, as 1.", shown="TEXT")
    output: Path | None = option(
        OUTPUT_OR_FOLDER,
        "PRN to write, or a folder: AccProf<motor>-<f>Hz-<variant>.PRN in it. "
        "Default: that name in the current folder.", "-o", "--output", shown="PATH",
    )  # fmt: skip
    csv: Path | None = option(OUTPUT, "Write the CSV profile for fast moves and homing too.")
    decode: str | None = shared.decode(
        "Motor that the CSV is for.", required=False, default_text="smooth",
        machine=machine.decode_of_csv,
    )  # fmt: skip
    name: str | None = option(
        TEXT, f"Name in the CSV's header, up to {NAME_WIDTH} characters.", shown="TEXT"
    )
    haps: int | None = option(
        Whole(0, MOST_HAPS), "HAPs of the CSV: entries used in homing. Default: all."
    )
    lead_in: int = option(
        Pixels(0, MOST_LEAD_IN), "LeadIn of the CSV: constant pixels before the image.", default=0
    )

    def run(self, desk: Desk) -> Result:
        """Make the profile and write its files."""
        hz = self.pixel_hz
        limits = generator.ProfileLimits(
            generator.legal_speed(self.top_speed.per_pixel(hz), hz),
            _legal(self.max_acceleration, hz, desk),
            _legal(self.max_jerk, hz, desk),
        )
        path = self._prn_path()
        speeds = generator.shortest_profile(limits)
        parts = self._csv_parts(speeds)
        csv = [("csv", self.csv)] if self.csv else []
        refuse_outputs([("output", path), *csv])  # the path may be that of a name
        with atomic.together():
            formats.write_prn(path, speeds)
            if self.csv and parts:
                formats.write_csv(self.csv, *parts)
        figures = _figures(speeds)
        data: MadeProfile = {
            "file": str(path),
            "csv": str(self.csv) if self.csv else None,
            "limits": {
                "top_speed_steps_per_px": limits.top_speed,
                "max_acceleration_steps_per_px2": limits.max_acceleration,
                "max_jerk_steps_per_px3": limits.max_jerk,
            },
            "figures": page.figures_json(figures, hz),
            "speeds": speeds,
        }

        def write(to: Page) -> None:
            length = f" = {float(len(speeds) / hz):.6g} s" if hz else ""
            to.tell(f"{path}: {len(speeds)} pixels{length}, {figures.steps} steps, even speeds")
            for name, order, value, limit in (
                ("top speed", SPEED, figures.peak_speed, limits.top_speed),
                ("acceleration", ACCELERATION, figures.peak_acceleration, limits.max_acceleration),
                ("jerk", JERK, figures.peak_jerk, limits.max_jerk),
            ):
                to.tell(f"  {name:<13}{units.both_text(value, order, hz)} (limit {limit})")
            if self.csv:
                to.tell(f"{self.csv}: the same as counts, for fast moves and homing")

        return Result(data, write)

    def _prn_path(self) -> Path:
        """Return where the PRN goes: the file given, or the conventional name in the folder."""
        motor, variant, hz, output = self.motor, self.variant, self.pixel_hz, self.output
        if output is not None and not output.is_dir():
            if motor or variant:
                raise AskedError(
                    "{path}: a file name is given, {motor} and {variant} have no use", path=output
                )
            return output
        if motor is None or variant is None or hz is None:
            parts = {"motor": motor, "variant": variant, "pixel_hz": hz}
            missing = ", ".join(f"{{{name}}}" for name, value in parts.items() if value is None)
            raise AskedError(
                f"the conventional name needs {missing}; or give a file name: {{output}}"
            )
        return (output or Path()) / origin.conventional_name(motor, hz, variant)

    def _csv_parts(self, speeds: list[int]) -> tuple[list[int], ProfileHeader] | None:
        """Return counts and header of the CSV, None if none is wanted.

        The counts end with one pixel of the top speed, so that it is reached under both decode
        rules.
        """
        if self.csv is None:
            for field in ("decode", "name", "haps", "lead_in"):
                if getattr(self, field):
                    raise AskedError(f"{{{field}}} is for the CSV profile: give {{csv}}")
            return None
        if self.pixel_hz is None:
            raise AskedError("{path}: the header of a CSV profile needs {pixel_hz}", path=self.csv)
        name = self.name or self.csv.stem
        if len(name) > NAME_WIDTH:
            raise AskedError(
                "header name {shown} is longer than {width} characters: give {name}",
                shown=repr(name), width=NAME_WIDTH,
            )  # fmt: skip
        top = speeds[-1]
        smooth = [*generator.acceleration_counts(speeds, top), top]
        counts = speeds if self.decode == PLAIN else smooth
        haps = len(counts) if self.haps is None else self.haps
        if haps > len(counts):
            raise AskedError(f"{{haps}} {haps}: the CSV profile has {len(counts)} entries")
        frequency = f"{float(self.pixel_hz):.10g}"
        return counts, ProfileHeader(time.ctime(), name, 1, haps, self.lead_in, frequency)


def _legal(limit: Quantity, hz: Fraction | None, desk: Desk) -> int:
    """Return a limit as an even whole number; a note says if that is less than was given."""
    given = limit.per_pixel(hz)
    legal = generator.legal_limit(given, limit.order, hz, limit)
    if legal != given:
        unit = units.unit(limit.order)
        desk.say([
            f"limit {units.number_text(given)} {unit}: changes are even, at most {legal} used"
        ])  # fmt: skip
    return legal


def _figures(speeds: list[int]) -> kinematics.LineMagnitudes:
    """Return the peaks of the line that the profile makes, and the length of the profile."""
    counts = tuple(generator.acceleration_counts(speeds, speeds[-1]))
    whole = kinematics.figures(Line(whole_line(counts, START)))
    return kinematics.LineMagnitudes(
        len(counts), sum(counts), whole.peak_speed, whole.peak_acceleration, whole.peak_jerk
    )


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
    lenient: bool = lenient()
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
            raise AskedError("{path}: {error}", path=self.file, error=error) from None

    def _limit(self) -> int | None:
        """Return the limit of the acceleration as an even number."""
        limit, hz = self.max_acceleration, self.pixel_hz
        if limit is None:
            return None
        return generator.legal_limit(limit.per_pixel(hz), limit.order, hz, limit)
