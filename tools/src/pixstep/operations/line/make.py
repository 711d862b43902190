# SPDX-License-Identifier: MIT
"""Make a line: of a profile, of a speed and an acceleration, or of a table of your own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, TypedDict

from pixstep import atomic, formats, owndata
from pixstep.errors import FINE, NEGATIVE, AskedText
from pixstep.formats.findings import counted
from pixstep.formats.header import MOST_LINES
from pixstep.lines import line_check, units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import FindingFacts
from pixstep.lines.units import Quantity, hz_text
from pixstep.operations import machine_defaults as machine
from pixstep.operations import reading_lines, shared
from pixstep.operations.asked import AskedError, AskedRefusedError
from pixstep.operations.clocks import OfClock
from pixstep.operations.desk import Desk
from pixstep.operations.facts import Facts
from pixstep.operations.kinds import (
    FILE,
    JERK_FIGURE,
    OUTPUT,
    SPEED_FIGURE,
    TEXT,
    Choice,
    Pixels,
    Steps,
    Text,
    Whole,
)
from pixstep.operations.request import argument, flag, operation, option
from pixstep.operations.result import Result
from pixstep.owndata.columns import QUANTITIES
from pixstep.owndata.table import BLANK, DECIMALS, NONE, SEPARATORS
from pixstep.profiles import accelerate, generator, origin
from pixstep.profiles.generator import MOST_PIXELS


class MadeLine(TypedDict):
    """A line that was written."""

    file: str
    pixels: int
    accelerating_pixels: int
    image_pixel: int
    steps: int
    backlash_steps: int
    speed_steps_s: float
    clock_hz: str
    pixel_hz: str
    divider: int


@operation("line make")
class LineMake(OfClock):
    """Make a line: up, constant speed, down, by a profile or by an acceleration.

    A pixel has as many edges of the pixel clock as the acceleration needs, or as --divider says; a
    file with more than one, or of a line that takes up backlash, gets a header with the frequency
    of its pixels and that backlash. Exit status 1 if the
    line is written but its acceleration changes by more than --jerk-warn.
    """

    result = MadeLine

    prn: Path | None = option(
        FILE, "Acceleration profile, PRN.", "--profile", machine=machine.profile("line")
    )
    max_acceleration: Quantity | None = shared.max_acceleration(
        "Instead of a profile: steps/px2, steps/s2 or mm/s2. A plain line with neither is "
        "constant: the motor starts at its full speed."
    )
    max_jerk: Quantity | None = shared.max_jerk("With --max-acceleration: steps/px3 or steps/s3.")
    speed: Quantity = option(
        SPEED_FIGURE, "Constant speed: 1000 (steps/pixel, even), 30000steps/s or 12mm/s.",
        required=True,
    )  # fmt: skip
    pixels: int | None = option(
        Pixels(most=MOST_PIXELS), "Length of the whole line, pixels.",
        machine=machine.of_line("pixels"),
    )  # fmt: skip
    length: int | None = option(
        Steps(1),
        "With --max-acceleration: length of the whole line, steps or 20mm; a short one is slower.",
    )
    divider: int | None = shared.divider(
        "Clock edges of a pixel.",
        default_text="1; with --max-acceleration the fewest that allow it",
    )
    backlash: int = shared.backlash()
    lead_in: int = option(
        Pixels(), "Constant pixels before the image.", default=0, machine=machine.lead_in,
    )  # fmt: skip
    decode: str | None = shared.decode(required=False, default_text="smooth")
    plain: bool = flag("", hidden=True)  # an older spelling of --decode plain
    negative: bool | None = flag(
        "Plain lines: negative counts.", off="--no-negative", default=None,
        machine=machine.negative_of_motor,
    )  # fmt: skip
    turn: bool = flag(
        "Plain lines: go half of the line, turn, and come back; --length is that of the way out."
    )
    lines: int = option(
        Whole(1, MOST_LINES), "Lines of the file, all alike; commands take one of many by --line "
                              "N.",
        default=1,
    )  # fmt: skip
    lenient: bool = flag("Accept LF and a missing final newline in the PRN.")
    jerk_warn: Quantity | None = option(JERK_FIGURE, "Warn of larger acceleration changes.")
    name: str | None = option(
        TEXT, "Write the 40-column header, named NAME.", "--header", shown="NAME"
    )
    output: Path = option(OUTPUT, "CSV file to write.", "-o", "--output", required=True)

    def run(self, desk: Desk) -> Result:
        """Make the line and write it."""
        if self.plain and self.decode == SMOOTH:
            raise AskedError("{plain} and {decode} smooth contradict each other")
        line = _made(self, desk)
        line_hz = self.edges_hz / line.divider
        if desk.given("negative") and self.negative and not self.is_plain:
            desk.say([AskedText(
                "counts of a smooth line have no sign: {negative} for `sim` and `board upload`"
            )])  # fmt: skip
        sign = -1 if self.is_plain and self.negative else 1
        play = None if self.is_plain else self.backlash
        if self.name is None and self.lines == 1:
            header = origin.of_pixels(self.output, self.lead_in, line_hz, line.divider, play)
        else:
            name = self.name or origin.plain_name(self.output)
            header = origin.header(name, self.lead_in, line_hz, play)
        counts = [sign * count for count in line.made.counts]
        formats.write_motion(self.output, formats.of_lines([counts] * self.lines, header))
        status = FINE
        if self.jerk_warn is not None and not self.is_plain:
            status = _warn_of_jerk(desk, line, units.whole_limit(self.jerk_warn, line_hz, least=0))
        data = _data(self, line)
        use = _use_text(desk.facts, line.divider)
        text = AskedText("{text}{use}", text=_text(data, line_hz), use=use)
        return Result(data, text, status)

    @property
    def is_plain(self) -> bool:
        """True for a plain line."""
        return self.plain or self.decode == PLAIN


@dataclass(frozen=True)
class _MadeLine:
    """A line, its speed in steps/pixel, the clock edges of its pixels."""

    made: generator.GeneratedLine
    speed: int
    divider: int


Make = Callable[[LineMake, Desk, generator.LineRequest], _MadeLine]


def _made(asked: LineMake, desk: Desk) -> _MadeLine:
    request = generator.LineRequest(
        0, asked.pixels or 0, asked.backlash, asked.lead_in, asked.is_plain
    )
    if desk.given("prn") and desk.given("max_acceleration"):
        raise AskedError("{prn} and {max_acceleration}: a line is made by one of them")
    if desk.given("pixels") and desk.given("length"):
        raise AskedError("{pixels} and {length}: a line has one of them")
    constant = asked.prn is None and asked.max_acceleration is None
    if constant and not asked.is_plain:
        raise AskedError("a line needs {prn} or {max_acceleration}")
    if asked.pixels is None and asked.length is None:
        raise AskedError("a line needs {pixels} or {length}")
    make = _constant if constant else _of_acceleration
    if asked.prn is not None and not desk.given("max_acceleration"):
        make = _of_profile
    return _turned(asked, desk, make, request) if asked.turn else make(asked, desk, request)


def _turned(asked: LineMake, desk: Desk, make: Make, request: generator.LineRequest) -> _MadeLine:
    """Make a line that turns: a way out, a rest, and the way back."""
    if not asked.is_plain:
        raise AskedError("{turn}: only a plain line turns: {decode} plain")
    way, rest = generator.way_of(request.pixels)
    if asked.pixels is not None and way < 1:
        raise AskedError("{turn}: {pixels} 3 at least")
    made = make(asked, desk, replace(request, pixels=way))
    advice = generator.slow_first_pixels(f"the motor of {asked.output}", made.made.counts)
    desk.say([advice] if advice else [])
    counts = generator.forth_and_back(made.made.counts, 1 if asked.pixels is None else rest)
    return replace(made, made=replace(made.made, counts=list(counts)))


def _constant(asked: LineMake, desk: Desk, request: generator.LineRequest) -> _MadeLine:
    """Make a plain line of equal counts."""
    if asked.length is not None or desk.given("max_jerk"):
        raise AskedError("{length}, {max_jerk}: only with {max_acceleration}")
    divider = asked.divider or 1
    scale = desk.facts.scale()
    speed = units.whole_speed(asked.speed, asked.edges_hz / divider, scale, smooth=False)
    made = generator.constant(replace(request, speed=speed))
    return _MadeLine(made, speed, divider)


def _of_profile(asked: LineMake, desk: Desk, request: generator.LineRequest) -> _MadeLine:
    """Make a line by a profile, whose speeds are per pixel."""
    profile = asked.prn
    assert profile is not None
    if asked.length is not None:
        raise AskedError("{length}: only with {max_acceleration}; by a profile {pixels} says it")
    if desk.given("max_jerk"):
        raise AskedError("{max_jerk}: only with {max_acceleration}; a profile has its own")
    divider = asked.divider or 1
    line_hz = asked.edges_hz / divider
    speeds, notes = formats.read_prn(profile, lenient=asked.lenient)
    desk.say([*notes, *reading_lines.motor_notes(desk.facts, profile, None)])
    desk.say(origin.frequency_notes(profile, None, line_hz, refuse=True))
    speed = units.whole_speed(asked.speed, line_hz, desk.facts.scale(), smooth=not asked.is_plain)
    made = generator.generate(speeds, replace(request, speed=speed), str(profile))
    return _MadeLine(made, speed, divider)


def _of_acceleration(asked: LineMake, desk: Desk, request: generator.LineRequest) -> _MadeLine:
    """Make the shortest ramps within an acceleration, in pixels that allow it."""
    scale, acceleration = desk.facts.scale(), asked.max_acceleration
    assert acceleration is not None
    wanted = accelerate.WantedLine(
        asked.speed.in_steps(scale), acceleration, asked.max_jerk, asked.edges_hz, asked.is_plain
    )
    divider = asked.divider or accelerate.choose_divider(wanted)
    made, speed, notes = accelerate.line(wanted, divider, asked.length, request, scale)
    desk.say(notes)
    return _MadeLine(made, speed, divider)


def _data(asked: LineMake, line: _MadeLine) -> MadeLine:
    made = line.made
    return {
        "file": str(asked.output),
        "pixels": len(made.counts),
        "accelerating_pixels": made.accelerating_pixels,
        "image_pixel": made.image_pixel,
        "steps": sum(map(abs, made.counts)) + asked.backlash,
        "backlash_steps": asked.backlash,
        "speed_steps_s": float(line.speed * asked.edges_hz / line.divider),
        "clock_hz": hz_text(asked.edges_hz),
        "pixel_hz": hz_text(asked.edges_hz / line.divider),
        "divider": line.divider,
    }


def _text(data: MadeLine, clock_hz: Fraction) -> str:
    return (
        f"{data['file']}: {data['pixels']} pixels, {data['accelerating_pixels']} accelerating, "
        f"image from pixel {data['image_pixel']}, {data['steps']} steps with backlash "
        f"{data['backlash_steps']}, {data['speed_steps_s']:g} steps/s at {float(clock_hz):g} Hz"
    )


def _use_text(facts: Facts, edges: int) -> AskedText:
    """Return where a line of several clock edges a pixel has to be told of them."""
    if edges == 1:
        return AskedText("")
    text = ", {edges} clock edges a pixel"
    found = facts.found
    if found is None:
        text += ": {divider} {edges} where it is used"
    elif found.clock.divider == edges:
        text += ", as {path} has it"
    else:
        text += ": {divider} {edges} where it is used, or divider = {edges} in the table [clock]"
        text += " of {path}"
    return AskedText(text, edges=edges, path=found and found.path)


def _warn_of_jerk(desk: Desk, line: _MadeLine, limit: int) -> int:
    """Say where the acceleration changes by more than `limit`; return the exit status."""
    counts = line.made.counts
    found = line_check.check(Line(tuple(counts)), line_check.Limits(jerk_warning=limit))
    jerks = [item for item in found if item.name == "jerk"]
    rising = [item for item in jerks if item.pixel <= len(counts) // 2]
    if not rising:
        return FINE
    desk.warn(f"pixel {item.pixel}: {item.message}, above {limit}" for item in rising)
    desk.warn([
        f"a profile made for this speed keeps the limit: "
        f"pixstep profile make --top-speed {line.speed} --max-jerk {limit} ..."
    ])  # fmt: skip
    return NEGATIVE


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
        Choice(QUANTITIES), "What the column holds for each pixel.",
        default_text="by the header; whole numbers: steps",
    )  # fmt: skip
    length_unit: str | None = option(
        TEXT, "steps, mm, um, deg ...; of speeds also mm/s or um/px.", "--unit", shown="UNIT",
        default_text="by the header",
    )  # fmt: skip
    separator: str | None = option(
        Choice((*SEPARATORS, BLANK, NONE)), "What separates the fields.", default_text="by the file"
    )
    decimal: str | None = option(
        Choice(tuple(DECIMALS)), "What separates the decimals; the other one separates thousands.",
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
