# SPDX-License-Identifier: MIT
"""Profiles and lines: read, made of a program's own numbers, checked, drawn, written."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from os import PathLike, fspath
from pathlib import Path
from typing import TYPE_CHECKING, Self, SupportsInt

from pixstep import formats, owndata
from pixstep.api.machines import Motor
from pixstep.board import limits, settings
from pixstep.errors import RefusedError, UserError
from pixstep.lines import linecheck, units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.linecheck import Finding, Limits
from pixstep.lines.rational import parse_hz
from pixstep.owndata.naming import QUANTITIES
from pixstep.profiles import generator, legal_prn, madefor, make, names

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Hz = Fraction | float | str
"""A pixel frequency: `30`, `29.97`, `"30000/1001"`, `Fraction(30)`."""


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
        whole = tuple(round(float(speed)) for speed in speeds_steps_px)
        if not whole or min(whole) < 0:
            raise UserError(f"{name}: expected speeds of 0 or more, one a pixel")
        return cls(legal_prn.repair_speeds(whole).values, name, exact_hz(pixel_hz))

    def write(self, path: str | PathLike[str]) -> Path:
        """Write a PRN file; return its path. An existing file is replaced."""
        formats.write_prn(Path(path), self.speeds_steps_px)
        return Path(path)


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
        if self.refused:
            first = self.errors[0]
            raise RefusedError(
                f"{self.name}: line refused: {first.name} at pixel {first.pixel}: {first.message}"
            )
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
        kind = board or (self.motor.board if self.motor else None)
        bounds = Limits()
        if kind and self.pixel_hz:
            sync = sync or (self.motor.sync if self.motor else None)
            divider = divider or (self.motor.divider if self.motor else None)
            clock = settings.of_clock(sync, divider)
            bounds = limits.named(kind, self.pixel_hz, axes=axes, clock=clock).of(self.line)
        return self.check_by(bounds, kind if self.pixel_hz else None)

    def check_by(self, bounds: Limits, board: str | None = None) -> CheckResult:
        """Check the line by given limits and those of the motor, whichever is lower."""
        if self.motor:
            bounds = _lower(bounds, self.motor.limits)
        found = linecheck.check(self.line, bounds)
        return CheckResult(self.line.name, tuple(found), self.pixel_hz, board)

    def write(self, path: str | PathLike[str]) -> Path:
        """Write the counts as a CSV file; return its path. An existing file is replaced.

        A file has neither decode rule nor backlash nor direction: `read_line` is told them again.
        """
        formats.write_csv(Path(path), self.counts)
        return Path(path)

    def plot(self) -> "Figure":
        """Draw speed, acceleration, jerk and position over the pixels."""
        from pixstep import plotting
        from pixstep.profiles import drawing, figure

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
    speeds, notes = formats.read_prn(Path(path), lenient=lenient)
    named = names.parse(Path(path))
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
        make.legal_speed(Fraction(top_speed)),
        make.legal_limit(Fraction(max_acceleration), units.ACCELERATION),
        make.legal_limit(Fraction(max_jerk), units.JERK),
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
    hz = exact_hz(pixel_hz) or (motor.pixel_hz if motor else profile.pixel_hz)
    rule = _decode(decode, motor)
    notes = [*profile.notes, *_other_frequency(profile, hz)]
    play = _backlash(backlash, rule, motor)
    request = generator.LineRequest(
        _steps_px(speed, hz, motor, rule), pixels, play, lead_in, plain=rule == PLAIN
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
    rule = _decode(decode, motor)
    values = [*counts]
    whole = tuple(int(value) for value in values)
    if any(value != exact for value, exact in zip(values, whole, strict=True)):
        raise UserError(f"{name}: the steps of a pixel are whole numbers")
    backwards = (motor.negative if motor else False) if negative is None else negative
    motion = Line(
        whole,
        rule,
        _backlash(backlash, rule, motor),
        backwards and rule == SMOOTH,
        name=name,
    )
    return MotionLine(motion, exact_hz(pixel_hz) or (motor.pixel_hz if motor else None), motor)


def read_line(
    path: str | PathLike[str],
    *,
    motor: Motor | None = None,
    number: int | None = None,
    pixel_hz: Hz | None = None,
    decode: str | None = None,
    backlash: int | None = None,
    negative: bool | None = None,
) -> MotionLine:
    """Read a line of a CSV or CSB file; `number` chooses one of several, from 1.

    The file has the counts only: the rest is as `line` has it. A header that says another pixel
    frequency is noted, and refused by RefusedError if the line would run faster.
    """
    place = Path(path)
    read = formats.read_motion(place)
    chosen = read.line(number)
    hz = exact_hz(pixel_hz) or (motor.pixel_hz if motor else madefor.frequency(place, read.header))
    notes = (*read.notes, *madefor.notes(place, read.header, hz, refuse=True))
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
    fit: bool = False,
) -> MotionLine:
    """Make a line of a table of your own: ordinary CSV, or what numpy's savetxt writes.

    `quantity` is what `column` (a name, or a number from 1) holds for each pixel: `"position"`,
    `"speed"` or `"steps"`; `unit` is that of a distance as `"mm"` or, of speeds, also `"mm/min"` or
    `"um/px"`. Without them the header says both; what stands in the place of a unit there and is
    none is refused. `fit` takes the nearest line that a smooth motor can make. What was assumed is
    in the line's notes. Raises UserError naming file, line and column.
    """
    if quantity not in (None, *QUANTITIES):
        raise UserError(f"quantity {quantity!r}: expected one of {', '.join(QUANTITIES)}")
    hz = exact_hz(pixel_hz) or (motor.pixel_hz if motor else None)
    rule = _decode(decode, motor)
    request = owndata.Request(
        rule,
        pixel_hz=hz,
        quantity=quantity,
        unit=unit,
        column=None if column is None else str(column),
        scale=motor.steps_per_unit if motor else None,
        negative=motor.negative if motor else False,
        fit=fit,
    )
    made = owndata.import_line(Path(path), request)
    motion = replace(made.line, backlash=_backlash(None, rule, motor))
    return MotionLine(motion, hz, motor, made.assumed)


def exact_hz(given: Hz | None) -> Fraction | None:
    """Return a pixel frequency as the board takes it: exact, of a float the digits it shows."""
    if given is None or isinstance(given, Fraction):
        return given
    return parse_hz(given if isinstance(given, str) else repr(given))


def _decode(given: str | None, motor: Motor | None) -> str:
    """Return the decode rule that is given, else the motor's, else smooth."""
    rule = given or (motor.decode if motor else SMOOTH)
    if rule not in (SMOOTH, PLAIN):
        raise UserError(f"decode {rule!r}: expected {SMOOTH!r} or {PLAIN!r}")
    return rule


def _backlash(given: int | None, rule: str, motor: Motor | None) -> int:
    """Return the backlash that is given, else the motor's: only smooth lines take it up."""
    if given is not None:
        return given
    return motor.backlash_steps if motor and rule == SMOOTH else 0


def _steps_px(speed: int | str, hz: Fraction | None, motor: Motor | None, rule: str) -> int:
    """Return a speed in whole steps/pixel. Raises UserError if it is none."""
    quantity = units.parse(str(speed), units.SPEED)
    if quantity.per_second and hz is None:
        raise UserError(f"speed {speed}: per second needs a pixel frequency: pixel_hz or motor")
    scale = motor.steps_per_unit if motor else None
    return units.whole_speed(quantity, hz, scale, smooth=rule == SMOOTH)


def _other_frequency(profile: Profile, hz: Fraction | None) -> list[str]:
    """Return a note of a profile made for another frequency; refuse one for a lower one."""
    if hz is None or profile.pixel_hz is None or profile.pixel_hz == hz:
        return []
    other = madefor.OtherFrequency(profile.name, profile.pixel_hz, hz)
    return [other.refuse_faster()]


def _lower(bounds: Limits, motor: Limits) -> Limits:
    """Return the lower of both limits wherever both have one."""

    def least(first: int | None, second: int | None) -> int | None:
        known = [value for value in (first, second) if value is not None]
        return min(known) if known else None

    return replace(
        bounds,
        max_speed=least(bounds.max_speed, motor.max_speed),
        max_acceleration=least(bounds.max_acceleration, motor.max_acceleration),
        start_stop=least(bounds.start_stop, motor.start_stop),
        jerk_warning=least(bounds.jerk_warning, motor.jerk_warning),
    )
