# SPDX-License-Identifier: MIT
"""Profiles and lines: read, made of a program's own numbers, checked, drawn, written."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import accumulate
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, SupportsInt

from pixstep import arguments, formats
from pixstep.api import given
from pixstep.api.given import Hz
from pixstep.api.machines import Motor
from pixstep.api.shown import Facts, LineRefusedError, Shown, count, frame
from pixstep.api.words import BoardKind, Decimals, Decode, Quantity, Separator
from pixstep.arguments import FAR
from pixstep.errors import RefusedError, UserError, told
from pixstep.lazy import lazy
from pixstep.lines import line_check
from pixstep.lines.line import SMOOTH, Line
from pixstep.lines.line_check import Finding, Limits
from pixstep.profiles import origin
from pixstep.profiles.generator import MOST_PIXELS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pixstep import owndata
    from pixstep.board import capability, guarantee, settings
    from pixstep.owndata import columns, table
    from pixstep.profiles import repair
else:  # what a line needs that is checked for a board, imported or repaired
    capability, guarantee = lazy("pixstep.board.capability"), lazy("pixstep.board.guarantee")
    settings, repair = lazy("pixstep.board.settings"), lazy("pixstep.profiles.repair")
    owndata, columns = lazy("pixstep.owndata"), lazy("pixstep.owndata.columns")
    table = lazy("pixstep.owndata.table")


@dataclass(frozen=True, repr=False)
class Profile(Shown):
    """How a motor accelerates: its speed at the end of each pixel, from rest.

    Example:
        >>> Profile((10, 20, 40)).top_speed_steps_px
        40
        >>> Profile.nearest([9.6, 21.2, 39.1]).speeds_steps_px
        (10, 20, 38)
    """

    speeds_steps_px: tuple[int, ...]
    """Speeds in steps/pixel; even and rising for a smooth motor."""
    name: str = "profile"
    """What messages call it: the file, if it comes from one."""
    pixel_hz: Fraction | None = None
    """Pixel frequency in Hz that it was made for; None if nothing says so."""
    notes: tuple[str, ...] = ()
    """What the reader of the file tolerated."""

    def __post_init__(self) -> None:
        """Raise UserError for what cannot be speeds."""
        speeds = arguments.wholes("speeds_steps_px", self.speeds_steps_px, 0, FAR, MOST_PIXELS)
        object.__setattr__(self, "speeds_steps_px", speeds)
        object.__setattr__(self, "pixel_hz", given.exact_hz(self.pixel_hz))
        arguments.text("name", self.name)

    @property
    def top_speed_steps_px(self) -> int:
        """The speed that it ends with."""
        return self.speeds_steps_px[-1] if self.speeds_steps_px else 0

    @classmethod
    def nearest(
        cls, speeds_steps_px: Iterable[float], *, name: str = "profile", pixel_hz: Hz | None = None
    ) -> "Profile":
        """Return a smooth motor's profile nearest to some speeds: even, above 0, never falling.

        `speeds_steps_px` are in steps/pixel and may be an array of numpy.
        """
        speeds = arguments.finites(
            arguments.text("name", name), speeds_steps_px, 0, FAR, MOST_PIXELS
        )
        if not speeds:
            raise UserError(f"{name}: expected speeds of 0 or more, one a pixel")
        whole = tuple(map(round, speeds))
        return cls(repair.repair_speeds(whole).values, name, given.exact_hz(pixel_hz))

    def to_dataframe(self) -> Any:
        """Return a pandas.DataFrame, or a pyarrow.Table where there is no pandas: a row a pixel."""
        pixels = range(1, len(self.speeds_steps_px) + 1)
        return frame({"pixel": pixels, "speed_steps_px": self.speeds_steps_px})

    def _headline(self) -> str:
        made_for = f", made for {float(self.pixel_hz):g} Hz" if self.pixel_hz else ""
        pixels = count(len(self.speeds_steps_px), "pixel")
        return f"{self.name}: {pixels} to {self.top_speed_steps_px} steps/px{made_for}"

    def _facts(self) -> Facts:
        yield from (("note", note) for note in self.notes)

    def write(self, path: str | PathLike[str]) -> Path:
        """Write a PRN file; return its path. An existing file is replaced."""
        target = arguments.path("path", path)
        formats.write_prn(target, self.speeds_steps_px)
        return target


@dataclass(frozen=True, repr=False)
class CheckResult(Shown):
    """What the board's own check says of a line, and what only the motor's limits add."""

    name: str
    """The line."""
    findings: tuple[Finding, ...]
    """Errors, which refuse the line, and warnings; by pixel, from 1."""
    pixel_hz: Fraction | None
    """Pixel frequency in Hz; None if it is not known: no step rate was checked then."""
    board: str | None
    """Kind of the board whose limits were kept; None if only the counts were checked."""

    @property
    def errors(self) -> tuple[Finding, ...]:
        """The findings that refuse the line."""
        return tuple(item for item in self.findings if item.severity == line_check.ERROR)

    @property
    def refused(self) -> bool:
        """True if the board would refuse the line."""
        return bool(self.errors)

    def with_guarantee(self, line: Line, axes: int, world: "guarantee.LineConditions") -> Self:
        """Return it with where the board may be late, if nothing else refuses the line.

        `axes` of the board move by it.
        """
        if self.refused:
            return self
        more = guarantee.findings([line] * axes, world)
        return replace(self, findings=(*self.findings, *more))

    def raise_if_refused(self) -> Self:
        """Raise LineRefusedError naming the first error and its pixel; else return the result."""
        try:
            line_check.raise_if_refused(self.name, self.findings)
        except RefusedError as error:
            raise LineRefusedError(str(error), self.errors) from None
        return self

    def to_dataframe(self) -> Any:
        """Return a pandas.DataFrame, or a pyarrow.Table without pandas: a row a finding."""
        names = ("pixel", "severity", "name", "message")
        return frame({name: [getattr(one, name) for one in self.findings] for name in names})

    def _headline(self) -> str:
        errors, warnings = len(self.errors), len(self.findings) - len(self.errors)
        found = f"{count(errors, 'error')}, {count(warnings, 'warning')}"
        return f"of {self.name}: {'refused' if self.refused else 'fine'}, {found}"

    def _facts(self) -> Facts:
        for one in self.findings:
            yield f"pixel {one.pixel}", f"{one.severity}: {one.name}: {one.message}"


@dataclass(frozen=True, repr=False)
class MotionLine(Shown):
    """A line for one axis: the steps of each pixel, the pixel frequency, and whose it is.

    The pixel frequency is that of pixels, also where one is several edges of the clock: the clock
    has `divider` times that frequency.
    """

    line: Line
    """Counts, decode rule, backlash and direction."""
    pixel_hz: Fraction | None = None
    """Pixel frequency in Hz; None if it is not known."""
    motor: Motor | None = None
    """The motor that it is for; None if no machine file was used."""
    notes: tuple[str, ...] = ()
    """What was assumed or tolerated on the way."""
    image_pixel: int | None = None
    """Pixel, from 1, in which the image starts, of a line that `make_line` has made."""
    divider: int | None = None
    """Clock edges of its pixels, of a line that was made for so many; a run takes it from here."""
    deviation_steps: float | None = None
    """How far it is at most from the positions that it was made of; None of other lines."""

    def __post_init__(self) -> None:
        """Raise UserError for what is no line."""
        arguments.instance("line", self.line, Line, "a Line, as `line` makes it")
        given.motor(self.motor)
        object.__setattr__(self, "pixel_hz", given.exact_hz(self.pixel_hz))

    @property
    def counts(self) -> tuple[int, ...]:
        """Steps of each pixel."""
        return self.line.counts

    @property
    def pixels(self) -> int:
        """Number of pixels."""
        return self.line.pixels

    @property
    def total_steps(self) -> int:
        """STEP pulses of the whole line, the backlash included."""
        return self.line.total_steps

    @property
    def axis(self) -> int:
        """The axis of its motor; 0 without one."""
        return self.motor.axis if self.motor else 0

    def check(
        self,
        board: BoardKind | None = None,
        *,
        axes: int = 1,
        sync: str | None = None,
        divider: int | None = None,
        guaranteed: bool = True,
    ) -> CheckResult:
        """Check the line as a board would, by the firmware's own check, and by the motor's limits.

        `board` is `"uno"`, `"mega"` or `"m1284"`, by default that of the motor. `axes` is the
        number of axes that move together, its own included: each of them by a line like this one.
        `sync` and `divider` are as for `simulate`: a pixel that is locked to the clock may be
        shorter. Without a board or a pixel frequency the shortest interval and the reversal time
        are not checked, nor whether the board has the time for the line (`beyond_guarantee`), which
        `guaranteed=False` leaves out.
        """
        motor = self.motor
        kind = given.board(board) or (motor.board if motor else None)
        sync, divider = given.sync(sync), given.divider(divider)
        count = given.axes(axes, kind)
        if kind is None or self.pixel_hz is None:
            return self.check_by(Limits())
        clock = settings.of_clock(
            sync or (motor.sync if motor else None), divider or (motor.divider if motor else None)
        )
        bounds = capability.named_limits(kind, self.pixel_hz, axes=count, clock=clock).of(self.line)
        found = self.check_by(bounds, kind)
        if not arguments.flag("guaranteed", guaranteed):
            return found
        return found.with_guarantee(self.line, count, guarantee.world(kind, self.pixel_hz, clock))

    def check_by(self, bounds: Limits, board: str | None = None) -> CheckResult:
        """Check the line by given limits and those of the motor, whichever is lower."""
        arguments.instance("bounds", bounds, Limits, "Limits")
        board = given.board(board)
        if self.motor:
            bounds = bounds.lower(self.motor.limits.with_rounding(self.line))
        found = line_check.check(self.line, bounds)
        return CheckResult(self.line.name, tuple(found), self.pixel_hz, board)

    def write(self, path: str | PathLike[str]) -> Path:
        """Write the counts as a CSV file; return its path. An existing file is replaced.

        A file has neither decode rule nor backlash nor direction: `read_line` is told them again.
        """
        target = arguments.path("path", path)
        formats.write_csv(target, self.counts)
        return target

    def to_dataframe(self) -> Any:
        """Return a pandas.DataFrame, or a pyarrow.Table where there is no pandas: a row a pixel.

        Positions are those behind each pixel, from 0 at the beginning of the line.
        """
        sign = self.line.direction
        counts = [sign * steps for steps in self.counts]
        columns = {"pixel": range(1, self.pixels + 1), "steps": counts}
        return frame(columns | {"position_steps": list(accumulate(counts))})

    def _headline(self) -> str:
        hz = f" at {float(self.pixel_hz):g} Hz" if self.pixel_hz else ""
        motor = f", motor {self.motor.name}" if self.motor else ""
        size = f"{count(self.pixels, 'pixel')}{hz}, {count(self.total_steps, 'step')}"
        return f"{self.line.name}: {self.line.decode}, {size}{motor}"

    def _facts(self) -> Facts:
        yield "backlash", f"{self.line.backlash} steps"
        yield "top speed", f"{self.line.line_speed} steps/px"
        if self.image_pixel is not None:
            yield "image from pixel", self.image_pixel
        if self.divider is not None:
            yield "clock edges of a pixel", self.divider
        if self.deviation_steps is not None:
            yield "largest deviation", f"{self.deviation_steps:.3g} steps"
        yield from (("note", note) for note in self.notes)

    def plot(self) -> "Figure":
        """Draw speed, acceleration, jerk and position over the pixels."""
        from pixstep import plotting
        from pixstep.profiles import figure, kinematics

        given.refuse_empty(self.line)
        with plotting.styled(**{"axes.axisbelow": True}):
            return figure.build(
                kinematics.LineDrawing(
                    self.line, self.line.name, self.pixel_hz, image_pixel=self.image_pixel
                )
            )

    @cached_property
    def hz(self) -> Fraction:
        """The pixel frequency. Raises UserError if it is not known."""
        if self.pixel_hz is None:
            raise UserError(f"{self.line.name}: needs a pixel frequency: give pixel_hz or motor")
        return self.pixel_hz


def read_profile(path: str | PathLike[str], *, lenient: bool = False) -> Profile:
    """Read an acceleration profile from a PRN file.

    The pixel frequency comes from a conventional name, `AccProfM39-30Hz-1.PRN`. `lenient` accepts
    LF and a missing final newline. Raises UserError naming file, line and value.

    Example:
        >>> profile = read_profile("AccProfM39-30Hz-1.PRN")
        >>> profile.top_speed_steps_px, profile.pixel_hz
        (1280, Fraction(30, 1))
    """
    place = arguments.path("path", path)
    speeds, notes = formats.read_prn(place, lenient=arguments.flag("lenient", lenient))
    named = origin.parse_name(place)
    hz = named.pixel_hz if named else None
    return Profile(tuple(speeds), fspath(path), hz, tuple(notes))


def line(
    counts: Iterable[SupportsInt],
    *,
    motor: Motor | None = None,
    pixel_hz: Hz | None = None,
    decode: Decode | None = None,
    backlash: int | str | None = None,
    negative: bool | None = None,
    name: str = "line",
) -> MotionLine:
    """Return a line of given steps for each pixel: a list, or an array of numpy.

    Counts are the motor's own: signed in a plain line; a smooth line runs backwards as a whole
    (`negative`). `backlash` is in steps or, of a motor with steps_per_unit, as `"0.1 mm"`. What is
    not given is the motor's; without a motor the line is smooth and has no backlash.

    Example:
        >>> line([2, 6, 8, 6, 2], decode="smooth", pixel_hz=30).check("uno").refused
        False
        >>> line([2, 9, 8, 6, 2], decode="smooth").check().errors[0].pixel
        5
    """
    motor = given.motor(motor)
    rule = given.decode(decode, motor)
    name = arguments.text("name", name)
    whole = arguments.wholes(name, counts, -FAR, FAR, MOST_PIXELS)
    if negative is None:
        backwards = motor.negative if motor else False
    else:
        backwards = arguments.flag("negative", negative)
    motion = Line(
        whole,
        rule,
        given.backlash(backlash, rule, motor),
        backwards and rule == SMOOTH,
        name=name,
    )
    return MotionLine(
        motion, given.exact_hz(pixel_hz) or (motor.pixel_hz if motor else None), motor
    )


def read_line(
    path: str | PathLike[str],
    *,
    motor: Motor | None = None,
    number: int | None = None,
    pixel_hz: Hz | None = None,
    decode: Decode | None = None,
    backlash: int | str | None = None,
    negative: bool | None = None,
    check: bool = True,
) -> MotionLine:
    """Read a line of a CSV or CSB file; `number` chooses one of several, from 1.

    The file has the counts, and its header may have the backlash that they were made for, which
    comes before the motor's; the rest is as `line` has it. A header that says another pixel
    frequency is noted, and refused by RefusedError if the line would run faster, unless `check` is
    False. A name or header of another motor is noted.
    """
    place = arguments.path("path", path)
    motor = given.motor(motor)
    number = given.maybe(arguments.whole, "number", number, 1)
    read = formats.read_motion(place)
    with given.number_for_line():
        chosen = read.line(number)
    hz = given.exact_hz(pixel_hz) or (
        motor.pixel_hz if motor else origin.frequency_of(place, read.header)
    )
    refuse = arguments.flag("check", check)
    rule = given.decode(decode, motor)
    asked = origin.AskedBacklash(
        given.backlash(backlash, rule, motor),
        backlash is not None,
        f"motor {motor.name}" if motor else "",
    )
    play, said = origin.taken(fspath(path), read.header, chosen.values, rule, asked)
    notes = (
        *read.notes,
        *said,
        *other_motor(place, read.header, motor),
        *origin.frequency_notes(place, read.header, hz, refuse=refuse),
    )
    made = line(
        chosen.values, motor=motor, pixel_hz=hz, decode=decode, backlash=play,
        negative=negative, name=fspath(path),
    )  # fmt: skip
    return replace(made, notes=notes)


def import_line(
    path: str | PathLike[str],
    *,
    motor: Motor | None = None,
    pixel_hz: Hz | None = None,
    decode: Decode | None = None,
    quantity: Quantity | None = None,
    unit: str | None = None,
    column: str | int | None = None,
    separator: Separator | None = None,
    decimal: Decimals | None = None,
    fit: bool = False,
) -> MotionLine:
    """Make a line of your own table: what a spreadsheet exports, or what numpy's savetxt writes.

    `quantity` is what `column` (a name, or a number from 1) holds for each pixel: `"position"`,
    `"speed"` or `"steps"`; `unit` is that of a distance as `"mm"` or, of speeds, also `"mm/min"` or
    `"um/px"`. Without them the header says both; what stands in the place of a unit there and is
    none is refused. A file that can be read in two ways is refused with both: `separator`
    (`"comma"`, `"semicolon"`, `"tab"`, `"bar"`, `"blank"`, `"none"`) and `decimal` (`"point"`,
    `"comma"`) choose. `fit` takes the nearest line that a smooth motor can make. What was assumed
    is in the line's notes. Raises UserError naming file, line and column.
    """
    place = arguments.path("path", path)
    motor = given.motor(motor)
    hz = given.exact_hz(pixel_hz) or (motor.pixel_hz if motor else None)
    rule = given.decode(decode, motor)
    request = owndata.ImportRequest(
        rule,
        pixel_hz=hz,
        quantity=given.maybe(arguments.one_of, "quantity", quantity, columns.QUANTITIES),
        unit=given.maybe(arguments.text, "unit", unit),
        column=_column(column),
        scale=motor.steps_per_unit if motor else None,
        negative=motor.negative if motor else False,
        fit=arguments.flag("fit", fit),
        separator=given.maybe(
            arguments.one_of, "separator", separator, (*table.SEPARATORS, table.BLANK, table.NONE)
        ),
        decimal=given.maybe(arguments.one_of, "decimal", decimal, tuple(table.DECIMALS)),
    )
    made = owndata.import_line(place, request)
    motion = replace(made.line, backlash=given.backlash(None, rule, motor))
    deviation = float(made.largest_error_steps)
    notes = tuple(told(note, {"no_negative": "negative=False"}) for note in made.assumed)
    return MotionLine(motion, hz, motor, notes, deviation_steps=deviation)


def _column(given: str | int | None) -> str | None:
    """Return a column of a table by its name or its number, as a text."""
    if given is None or isinstance(given, str):
        return given
    return str(arguments.whole("column", given, 1))


def other_motor(path: Path, header: formats.ProfileHeader | None, motor: Motor | None) -> list[str]:
    """Return a note of a file that is made for another motor."""
    if motor is None:
        return []
    return origin.other_motor(path, header.name if header else None, motor.name)
