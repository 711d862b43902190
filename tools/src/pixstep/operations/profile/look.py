# SPDX-License-Identifier: MIT
"""Look at an acceleration profile: check what it may be, show what it does."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any, TypedDict

from pixstep.errors import AskedText
from pixstep.lines import line_check, units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import Finding, FindingFacts
from pixstep.lines.units import ACCELERATION, JERK, SPEED, Quantity
from pixstep.operations import machine_defaults as machine
from pixstep.operations import reading_lines, shared, showing
from pixstep.operations.asked import AskedError
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, SPEED_FIGURE
from pixstep.operations.request import Request, argument, flag, operation, option
from pixstep.operations.result import STATUSES, VERDICTS, Page, Result
from pixstep.operations.showing import ShownMotion
from pixstep.profiles import generator, page, readings
from pixstep.profiles.kinematics import LineDrawing
from pixstep.profiles.readings import ProfileFile, ProfileReading

_FORMS = {
    readings.PRN: "PRN speeds",
    readings.BLOCK: "block after the header",
    readings.ROWS: "all rows as values",
}
_REPAIRABLE = {"speed", "oscillates", "reverses_inside_pixel"}


def lenient() -> Any:
    """Return the flag of a PRN that is read although it is not quite one."""
    return flag("Accept LF and a missing final newline in a PRN.")


def _decode(about: str) -> Any:
    return shared.decode(about, required=False, machine=machine.decode_if_named)


class ReadingFacts(TypedDict):
    """A reading of a file: what its rows are then, and what is wrong with that."""

    rows: str
    adopted: bool
    decode: str | None
    state: str
    problem: str | None
    findings: list[FindingFacts]


class CheckedProfile(TypedDict):
    """What a check says of a profile."""

    file: str
    verdict: str
    readings: list[ReadingFacts]
    advice: list[str]


@operation("profile check")
class ProfileCheck(Request):
    """Check a profile under every reading of its file.

    Exit status 0 fine, 1 warnings or a reading that fails, 3 no reading is sound.
    """

    result = CheckedProfile

    file: Path = argument(FILE)
    decode: str | None = _decode("What the motor is. Default: by the motor in the name, else both.")
    raw: bool = shared.raw()
    lenient: bool = lenient()
    pixel_hz: Fraction | None = shared.pixel_hz(
        "Pixel frequency, for limits per second.", required=False
    )
    max_speed: Quantity | None = shared.max_speed()
    max_acceleration: Quantity | None = shared.max_acceleration()
    max_jerk: Quantity | None = shared.max_jerk()

    def run(self, desk: Desk) -> Result:
        """Check every reading."""
        read, hz = _read(self, desk)
        limits = showing.limits(hz, self.max_speed, self.max_acceleration, self.max_jerk)
        bounds = line_check.Limits(
            max_speed=limits.get(SPEED),
            max_acceleration=limits.get(ACCELERATION),
            jerk_warning=limits.get(JERK),
        )
        decode = self.decode or reading_lines.motor_decode(desk.facts, self.file)
        found = readings.check(read, decode, bounds)
        severity = readings.exit_status(found)
        data: CheckedProfile = {
            "file": str(self.file),
            "verdict": VERDICTS[severity],
            "readings": [
                {
                    "rows": reading.rows.form,
                    "adopted": reading.rows.adopted,
                    "decode": reading.decode or None,
                    "state": _state(reading),
                    "problem": reading.rows.problem or None,
                    "findings": line_check.as_json(reading.findings),
                }
                for reading in found
            ],
            "advice": list(_advice(found)),
        }

        def write(to: Page) -> None:
            for reading in found:
                to.tell(f"{_name(reading)}: {reading.rows.problem or _state(reading)}")
                items = reading.findings if reading.rows.adopted else ()
                for text in page.first_lines([_finding_text(item) for item in items]):
                    to.tell(f"  {text}")
            for text in data["advice"]:
                to.tell(text)
            to.tell(f"{self.file}: {data['verdict']}")

        return Result(data, write, STATUSES[severity])


@operation("profile show")
class ProfileShow(Request):
    """Show speed, acceleration, jerk and position of a profile: a table, with --plot a drawing."""

    result = ShownMotion

    file: Path = argument(FILE)
    decode: str | None = _decode("Default: by the motor in the name, else smooth.")
    speed: Quantity | None = option(SPEED_FIGURE, "Draw the line up to this speed, steps/px.")
    raw: bool = shared.raw()
    lenient: bool = lenient()
    pixel_hz: Fraction | None = shared.pixel_hz(
        "Pixel frequency. Default: by the name or the header.", required=False
    )
    max_speed: Quantity | None = shared.max_speed()
    max_acceleration: Quantity | None = shared.max_acceleration()
    max_jerk: Quantity | None = shared.max_jerk()
    plot: Path | None = shared.picture("-o", "--output")

    def run(self, desk: Desk) -> Result:
        """Make the counts of the profile and show them."""
        read, hz = _read(self, desk)
        top = None
        if self.speed is not None:
            smooth = self.decode != PLAIN
            top = units.whole_speed(self.speed, hz, desk.facts.scale(), smooth=smooth)
        decode = self.decode or reading_lines.motor_decode(desk.facts, self.file) or SMOOTH
        line = Line(_counts(read, decode, top), decode, name=str(self.file))
        bounds = showing.limits(hz, self.max_speed, self.max_acceleration, self.max_jerk)
        scale = desk.facts.scale_if_known()
        drawing = LineDrawing(line, self.file.name, hz, bounds, scale=scale, going_on=True)
        return showing.shown(drawing, self.plot)


def _read(asked: ProfileCheck | ProfileShow, desk: Desk) -> tuple[ProfileFile, Fraction | None]:
    """Return the profile and the frequency of its pixels."""
    read = readings.load(asked.file, raw=asked.raw, lenient=asked.lenient)
    desk.say(read.notes)
    return read, showing.used_frequency(desk, asked.pixel_hz, read.path, read.header)


def _counts(read: ProfileFile, decode: str, speed: int | None) -> tuple[int, ...]:
    """Return the counts that a profile makes, up to `speed` if it is given."""
    values = list(read.values)
    if not read.is_prn:
        if speed is not None:
            raise AskedError("{path}: {speed} is for a PRN, a CSV holds counts", path=read.path)
        return read.values
    if decode == PLAIN:
        top = speed or values[-1]
        return (*generator.plain_counts(values, top, str(read.path)), top)
    return tuple(generator.acceleration_counts(values, speed or values[-1], str(read.path)))


def _state(reading: ProfileReading) -> str:
    """Return one word for a reading."""
    if reading.rows.values is None:
        return "unreadable"
    if not reading.sound:
        return "fails"
    return "warnings" if reading.findings else "fine"


def _name(reading: ProfileReading) -> str:
    """Return what a reading takes the file for."""
    if reading.rows.values is None:
        return _FORMS[reading.rows.form]
    size = len(reading.rows.values)
    adopted = "" if reading.rows.adopted else " (not adopted)"
    return f"{_FORMS[reading.rows.form]}, {size}, decoded as {reading.decode}{adopted}"


def _finding_text(item: Finding) -> str:
    """Return a finding as a line."""
    where = f"entry {item.pixel}: " if item.pixel else ""
    return f"{where}{item.severity} {item.name}: {item.message}"


def _advice(found: list[ProfileReading]) -> Iterator[str]:
    """Yield what follows from readings that disagree."""
    adopted = [reading for reading in found if reading.rows.adopted]
    sound = {reading.decode for reading in adopted if reading.sound}
    if len(sound) == 1 and len(adopted) > 1:
        (good,) = sound
        use = "fast moves" if good == PLAIN else "homing and printing"
        yield f"ambiguous: sound only when decoded as {good} ({use})"
    if readings.ambiguous(found):
        yield "ambiguous: the rows fit a block too: line number 1, number of values, values"
    elif not sound and any(reading.sound for reading in found):
        yield AskedText("only all rows as values make a profile: {raw} reads them so")
    failing = (reading for reading in adopted if reading.decode == SMOOTH and not reading.sound)
    if any(item.name in _REPAIRABLE for reading in failing for item in reading.findings):
        yield "pixstep profile repair proposes values that a smooth motor can follow"
