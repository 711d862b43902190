# SPDX-License-Identifier: MIT
"""Profiles and lines: read, made of a program's own numbers, checked, drawn, written."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Self, SupportsInt

from pixstep import arguments, formats, owndata
from pixstep.api import given
from pixstep.api.given import Hz
from pixstep.api.machines import Motor
from pixstep.arguments import FAR
from pixstep.board import limits, settings
from pixstep.errors import UserError
from pixstep.lines import linecheck, units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.linecheck import Finding, Limits
from pixstep.owndata.naming import QUANTITIES
from pixstep.owndata.numerals import DECIMALS
from pixstep.owndata.table import BLANK, NONE, SEPARATORS
from pixstep.profiles import generator, legal_prn, madefor, make, names
from pixstep.profiles.generator import MOST_PIXELS

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Profile:
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
        return cls(legal_prn.repair_speeds(whole).values, name, given.exact_hz(pixel_hz))

    def write(self, path: str | PathLike[str]) -> Path:
        """Write a PRN file; return its path. An existing file is replaced."""
        target = arguments.path("path", path)
        formats.write_prn(target, self.speeds_steps_px)
        return target


@dataclass(frozen=True)
class CheckResult:
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
        return tuple(item for item in self.findings if item.severity == linecheck.ERROR)

    @property
    def refused(self) -> bool:
        """True if the board would refuse the line."""
        return bool(self.errors)

    def raise_if_refused(self) -> Self:
        """Raise RefusedError naming the first error and its pixel; return the result if fine."""
        linecheck.raise_if_refused(self.name, self.findings)
        return self


@dataclass(frozen=True)
class MotionLine:
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
        board: str | None = None,
        *,
        axes: int = 1,
        sync: str | None = None,
        divider: int | None = None,
    ) -> CheckResult:
        """Check the line as a board would, by the firmware's own check, and by the motor's limits.

        `board` is `"uno"`, `"mega"` or `"m1284"`, by default that of the motor. `axes` is the
        number of axes that move together, its own included. `sync` and `divider` are as for
        `simulate`: a pixel that is locked to the clock may be shorter. Without a board or a pixel
        frequency the shortest interval and the reversal time are not checked.
        """
        motor = self.motor
        kind = given.board(board) or (motor.board if motor else None)
        sync, divider = given.sync(sync), given.divider(divider)
        count = given.axes(axes, kind)
        bounds = Limits()
        if kind and self.pixel_hz:
            clock = settings.of_clock(
                sync or (motor.sync if motor else None),
                divider or (motor.divider if motor else None),
            )
            bounds = limits.named(kind, self.pixel_hz, axes=count, clock=clock).of(self.line)
        return self.check_by(bounds, kind if self.pixel_hz else None)

    def check_by(self, bounds: Limits, board: str | None = None) -> CheckResult:
        """Check the line by given limits and those of the motor, whichever is lower."""
        arguments.instance("bounds", bounds, Limits, "Limits")
        board = given.board(board)
        if self.motor:
            bounds = bounds.lower(self.motor.limits.with_rounding(self.line))
        found = linecheck.check(self.line, bounds)
        return CheckResult(self.line.name, tuple(found), self.pixel_hz, board)

    def write(self, path: str | PathLike[str]) -> Path:
        """Write the counts as a CSV file; return its path. An existing file is replaced.

        A file has neither decode rule nor backlash nor direction: `read_line` is told them again.
        """
        target = arguments.path("path", path)
        formats.write_csv(target, self.counts)
        return target

    def plot(self) -> "Figure":
        """Draw speed, acceleration, jerk and position over the pixels."""
        from pixstep import plotting
        from pixstep.profiles import drawing, figure

        given.refuse_empty(self.line)
        with plotting.styled(**{"axes.axisbelow": True}):
            return figure.build(
                drawing.Drawing(
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
    named = names.parse(place)
    hz = named.pixel_hz if named else None
    return Profile(tuple(speeds), fspath(path), hz, tuple(notes))


def make_profile(
    top_speed: int, max_acceleration: int, max_jerk: int, *, name: str = "profile"
) -> Profile:
    """Make the shortest profile of a smooth motor within limits.

    `top_speed` is in steps/pixel, `max_acceleration` in steps/pixel2, `max_jerk`, the change of the
    acceleration from pixel to pixel, in steps/pixel3.

    Example:
        >>> make_profile(40, 16, 8).speeds_steps_px
        (8, 20, 32, 40)
    """
    bounds = make.ProfileLimits(
        make.legal_speed(arguments.exact("top_speed", top_speed, 0)),
        make.legal_limit(
            arguments.exact("max_acceleration", max_acceleration, 0), units.ACCELERATION
        ),
        make.legal_limit(arguments.exact("max_jerk", max_jerk, 0), units.JERK),
    )
    return Profile(tuple(make.shortest_profile(bounds)), name)


def make_line(
    profile: Profile,
    *,
    speed: int | str,
    pixels: int,
    motor: Motor | None = None,
    pixel_hz: Hz | None = None,
    decode: str | None = None,
    backlash: int | None = None,
    lead_in: int = 0,
) -> MotionLine:
    """Make a line from a profile: up to the speed, constant, down again.

    `speed` is in steps/pixel, or a text with a unit: `"30000 steps/s"`, and of a motor with
    steps_per_unit `"12 mm/s"`. `pixels` is the length of the whole line, `lead_in` the constant
    pixels before the image. The motor says the rest, unless it is given here; without a motor the
    line is smooth, has no backlash, and the pixel frequency is the profile's. Raises UserError for
    a request that cannot be met, RefusedError for a profile made for a lower pixel frequency.

    Example:
        >>> made = make_line(Profile((10, 20, 40)), speed=30, pixels=9, pixel_hz=30)
        >>> made.counts
        (5, 15, 25, 30, 30, 30, 25, 15, 5)
    """
    profile = arguments.instance("profile", profile, Profile, "a Profile")
    motor = given.motor(motor)
    hz = given.exact_hz(pixel_hz) or (motor.pixel_hz if motor else profile.pixel_hz)
    rule = given.decode(decode, motor)
    notes = [
        *profile.notes,
        *_other_motor(Path(profile.name), None, motor),
        *_other_frequency(profile, hz),
    ]
    play = given.backlash(backlash, rule, motor)
    request = generator.LineRequest(
        _steps_px(speed, hz, motor, rule),
        arguments.whole("pixels", pixels),
        play,
        arguments.whole("lead_in", lead_in),
        plain=rule == PLAIN,
    )
    made = generator.generate(list(profile.speeds_steps_px), request, profile.name)
    sign = -1 if rule == PLAIN and motor and motor.negative else 1
    counts = tuple(sign * count for count in made.counts)
    built = line(counts, motor=motor, pixel_hz=hz, decode=rule, backlash=play, name=profile.name)
    return replace(built, notes=tuple(notes), image_pixel=made.image_pixel)


def line(
    counts: Iterable[SupportsInt],
    *,
    motor: Motor | None = None,
    pixel_hz: Hz | None = None,
    decode: str | None = None,
    backlash: int | None = None,
    negative: bool | None = None,
    name: str = "line",
) -> MotionLine:
    """Return a line of given steps for each pixel: a list, or an array of numpy.

    Counts are the motor's own: signed in a plain line; a smooth line runs backwards as a whole
    (`negative`). What is not given is the motor's; without a motor the line is smooth and has no
    backlash.

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
    decode: str | None = None,
    backlash: int | None = None,
    negative: bool | None = None,
    check: bool = True,
) -> MotionLine:
    """Read a line of a CSV or CSB file; `number` chooses one of several, from 1.

    The file has the counts only: the rest is as `line` has it. A header that says another pixel
    frequency is noted, and refused by RefusedError if the line would run faster, unless `check` is
    False. A name or header of another motor is noted.
    """
    place = arguments.path("path", path)
    motor = given.motor(motor)
    number = None if number is None else arguments.whole("number", number, 1)
    read = formats.read_motion(place)
    chosen = read.line(number)
    hz = given.exact_hz(pixel_hz) or (
        motor.pixel_hz if motor else madefor.frequency(place, read.header)
    )
    refuse = arguments.flag("check", check)
    notes = (
        *read.notes,
        *_other_motor(place, read.header, motor),
        *madefor.notes(place, read.header, hz, refuse=refuse),
    )
    made = line(
        chosen.values, motor=motor, pixel_hz=hz, decode=decode, backlash=backlash,
        negative=negative, name=fspath(path),
    )  # fmt: skip
    return replace(made, notes=notes)


def import_line(
    path: str | PathLike[str],
    *,
    motor: Motor | None = None,
    pixel_hz: Hz | None = None,
    decode: str | None = None,
    quantity: str | None = None,
    unit: str | None = None,
    column: str | int | None = None,
    separator: str | None = None,
    decimal: str | None = None,
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
    request = owndata.Request(
        rule,
        pixel_hz=hz,
        quantity=_one_of("quantity", quantity, QUANTITIES),
        unit=None if unit is None else arguments.text("unit", unit),
        column=_column(column),
        scale=motor.steps_per_unit if motor else None,
        negative=motor.negative if motor else False,
        fit=arguments.flag("fit", fit),
        separator=_one_of("separator", separator, (*SEPARATORS, BLANK, NONE)),
        decimal=_one_of("decimal", decimal, tuple(DECIMALS)),
    )
    made = owndata.import_line(place, request)
    motion = replace(made.line, backlash=given.backlash(None, rule, motor))
    return MotionLine(motion, hz, motor, made.assumed)


def _one_of(name: str, given: str | None, choices: tuple[str, ...]) -> str | None:
    """Return one of several words, or None."""
    return None if given is None else arguments.one_of(name, given, choices)


def _column(given: str | int | None) -> str | None:
    """Return a column of a table by its name or its number, as a text."""
    if given is None or isinstance(given, str):
        return given
    return str(arguments.whole("column", given, 1))


def _speed(given: str | float) -> units.Quantity:
    """Return a speed in steps/pixel, or in the unit that it is written with."""
    if isinstance(given, str):
        return units.parse(given, units.SPEED)
    value = arguments.exact("speed", given, 0)
    return units.Quantity(value, units.SPEED, False, arguments.shown(given))


def _steps_px(speed: int | str, hz: Fraction | None, motor: Motor | None, rule: str) -> int:
    """Return a speed in whole steps/pixel. Raises UserError if it is none."""
    quantity = _speed(speed)
    if quantity.per_second and hz is None:
        raise UserError(f"speed {speed}: per second needs a pixel frequency: pixel_hz or motor")
    scale = motor.steps_per_unit if motor else None
    return units.whole_speed(quantity, hz, scale, smooth=rule == SMOOTH)


def _other_motor(
    path: Path, header: formats.ProfileHeader | None, motor: Motor | None
) -> list[str]:
    """Return a note of a file that is made for another motor."""
    made_for = names.motor_of(path, header.name if header else None)
    if motor is None or made_for in (None, motor.name):
        return []
    return [f"{path}: made for motor {made_for}, used for motor {motor.name}"]


def _other_frequency(profile: Profile, hz: Fraction | None) -> list[str]:
    """Return a note of a profile made for another frequency; refuse one for a lower one."""
    if hz is None or profile.pixel_hz is None or profile.pixel_hz == hz:
        return []
    other = madefor.OtherFrequency(profile.name, profile.pixel_hz, hz)
    return [other.refuse_faster()]
