# SPDX-License-Identifier: MIT
"""Profiles and lines that are made: of limits, of a profile, of an acceleration, of positions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from pixstep import arguments
from pixstep.api import given
from pixstep.api.given import Hz
from pixstep.api.machines import Motor
from pixstep.api.motions import MotionLine, Profile, other_motor, read_profile
from pixstep.api.words import Decode
from pixstep.arguments import FAR
from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.units import Scale
from pixstep.owndata import importing as through
from pixstep.profiles import accelerate, generator, origin
from pixstep.profiles.generator import MOST_PIXELS, GeneratedLine, LineRequest

_FINE = 1_000_000  # parts of a step, to which positions are taken exactly


def make_profile(
    top_speed: int | str,
    max_acceleration: int | str,
    max_jerk: int | str,
    *,
    motor: Motor | None = None,
    pixel_hz: Hz | None = None,
    name: str = "profile",
) -> Profile:
    """Make the shortest profile of a smooth motor within limits.

    `top_speed` is in steps/pixel, `max_acceleration` in steps/pixel2, `max_jerk`, the change of the
    acceleration from pixel to pixel, in steps/pixel3; or texts with units: with `pixel_hz` or a
    motor `"30000 steps/s"`, of a motor with steps_per_unit also `"12 mm/s"`. Limits with units are
    rounded down to what a profile can have.

    Example:
        >>> make_profile(40, 16, 8).speeds_steps_px
        (8, 20, 32, 40)
    """
    motor = given.motor(motor)
    hz = given.exact_hz(pixel_hz) or (motor.pixel_hz if motor else None)

    def even(key: str, value: int | str, order: int) -> Fraction:
        if not isinstance(value, str):
            return arguments.exact(key, value, 0)
        found = given.needs_hz(key, given.quantity(key, value, order, given.scale(None, motor)), hz)
        return found.per_pixel(hz) // 2 * Fraction(2)

    bounds = generator.ProfileLimits(
        generator.legal_speed(even("top_speed", top_speed, units.SPEED)),
        generator.legal_limit(
            even("max_acceleration", max_acceleration, units.ACCELERATION), units.ACCELERATION
        ),
        generator.legal_limit(even("max_jerk", max_jerk, units.JERK), units.JERK),
    )
    return Profile(tuple(generator.shortest_profile(bounds)), name, hz)


def make_line(
    profile: Profile | None = None,
    *,
    speed: int | str,
    pixels: int | str | None = None,
    length: int | str | None = None,
    max_acceleration: float | str | None = None,
    max_jerk: float | str | None = None,
    motor: Motor | None = None,
    pixel_hz: Hz | None = None,
    divider: int | None = None,
    decode: Decode | None = None,
    backlash: int | str | None = None,
    lead_in: int | str = 0,
    name: str | None = None,
) -> MotionLine:
    """Make a line: up to the speed, constant, down again, by a profile or by an acceleration.

    `speed` is in steps/pixel, or a text with a unit: `"30000 steps/s"`, and of a motor with
    steps_per_unit `"12 mm/s"`. `pixels` is the length of the whole line, `lead_in` the constant
    pixels before the image. The motor says the rest, unless it is given here; without a motor the
    line is smooth, has no backlash, and the pixel frequency is the profile's. Without `profile` and
    `max_acceleration` the profile is the one that the motor's machine file names.

    With `max_acceleration` (steps/pixel2, or `"500 mm/s2"`) and `max_jerk` instead of a profile the
    ramps are the shortest within them; `length` (steps, or `"20 mm"`) may then take the place of
    `pixels`: the line makes exactly so many steps, a short one more slowly. A pixel of a motor has
    as many edges of the machine's clock as the machine file says if that allows the acceleration,
    else the fewest that do, or `divider`: the line keeps the number, and a run takes it from there.

    Raises UserError for a request that cannot be met, RefusedError for a profile made for a lower
    pixel frequency.

    Example:
        >>> made = make_line(Profile((10, 20, 40)), speed=30, pixels=9, pixel_hz=30)
        >>> made.counts
        (5, 15, 25, 30, 30, 30, 25, 15, 5)
        >>> made = make_line(speed=40, max_acceleration=20, length=360, pixel_hz=100)
        >>> made.counts, made.total_steps
        ((10, 30, 40, 40, 40, 40, 40, 40, 40, 30, 10), 360)
    """
    motor = given.motor(motor)
    rule = given.decode(decode, motor)
    scale = given.scale(None, motor)
    if (pixels is None) == (length is None):
        raise UserError("a line has pixels or length: give one of them")
    asked = _Asked(
        speed=speed,
        length=given.maybe(given.steps, "length", length, scale, 1),
        hz=given.exact_hz(pixel_hz),
        divider=given.divider(divider),
        motor=motor,
        rule=rule,
        request=LineRequest(
            0,
            0 if pixels is None else given.pixels("pixels", pixels),
            given.backlash(backlash, rule, motor),
            given.pixels("lead_in", lead_in),
            plain=rule == PLAIN,
        ),
    )
    if max_acceleration is None:
        if max_jerk is not None:
            raise UserError("max_jerk: only with max_acceleration; a profile has its own")
        made = _by_profile(_profile(profile, motor), asked)
    elif profile is not None:
        raise UserError("profile and max_acceleration: a line is made by one of them")
    else:
        made = _by_acceleration(max_acceleration, max_jerk, asked)
    return made.line(asked, name)


def line_from_positions(
    positions: Iterable[float],
    *,
    unit: str = "steps",
    fit: bool = True,
    motor: Motor | None = None,
    steps_per_unit: str | Scale | None = None,
    pixel_hz: Hz | None = None,
    decode: Decode | None = None,
    backlash: int | str | None = None,
    name: str = "line",
) -> MotionLine:
    """Make a line of where the load is at each pixel's edge: a list, or an array of numpy.

    The first position is that of line zero, so that there is one more than pixels. `unit` is
    `"steps"`, or a length or an angle as `"mm"`, `"um"` or `"deg"`: steps for it are the motor's,
    or `steps_per_unit`, `"400 steps/mm"`. Positions are rounded to whole steps, errors never add
    up. `fit` takes the nearest line that the motor can make: a smooth one has even speeds at the
    pixel edges, from rest to rest. `deviation_steps` of the line is how far it is from the
    positions at most, and its notes say where. Whether the motor's limits are kept `check` says.
    A smooth line takes up the motor's backlash; a plain line does not, and a note says so where it
    turns: `ops.line_compensate` puts the steps in.

    Example:
        >>> places_mm = [0, 0.5, 2, 4, 5.5, 6]
        >>> made = line_from_positions(places_mm, unit="mm", steps_per_unit="20 steps/mm")
        >>> made.counts, made.deviation_steps
        ((10, 30, 40, 30, 10), 0.0)
    """
    motor = given.motor(motor)
    rule = given.decode(decode, motor)
    name = arguments.text("name", name)
    factor = steps_of(arguments.text("unit", unit), given.scale(steps_per_unit, motor))
    if motor and motor.negative:
        factor = -factor
    values = arguments.finites(name, positions, -FAR, FAR, MOST_PIXELS + 1)
    if len(values) < 2:
        raise UserError(f"{name}: expected two positions or more, one a pixel's edge")
    places = [_fine(value * factor) for value in values]
    made = through.line_of(
        [place - places[0] for place in places], rule, name,
        lambda pixel, text: UserError(f"{name}: pixel {pixel + 1}: {text}"),
        fitted=arguments.flag("fit", fit),
    )  # fmt: skip
    motion = replace(made.line, backlash=given.backlash(backlash, rule, motor))
    hz = given.exact_hz(pixel_hz) or (motor.pixel_hz if motor else None)
    deviation = float(made.largest_error_steps)
    notes = (*_deviation_notes(made, unit, abs(factor)), *_play_notes(motion, motor))
    return MotionLine(motion, hz, motor, notes, deviation_steps=deviation)


def _play_notes(line: Line, motor: Motor | None) -> tuple[str, ...]:
    """Say that a plain line which turns leaves the load behind by the motor's play."""
    if line.decode != PLAIN or not line.turns or motor is None or not motor.backlash_steps:
        return ()
    return (
        f"the play of {motor.backlash_steps} steps is not taken up where the line turns, and the "
        "load is off by as much: `pixstep line compensate` (px.ops.line_compensate) puts it in",
    )


def _deviation_notes(made: through.FittedLine, unit: str, factor: float) -> tuple[str, ...]:
    """Return in words how far a line is from its positions."""
    error = float(made.largest_error_steps)
    if not error:
        return ()
    in_unit = "" if unit in ("step", "steps") else f" = {error / factor:.3g} {unit}"
    how = "fitted" if made.fitted else "rounded to whole steps"
    return (
        f"{how}: at most {error:.3g} steps{in_unit} from the positions, after pixel "
        f"{made.worst_pixel}",
    )


def _fine(steps: float) -> Fraction:
    return Fraction(round(steps * _FINE), _FINE)


def steps_of(unit: str, scale: Scale | None) -> float:
    """Return how many steps a unit of length is."""
    found = units.parse_length_unit(unit)
    if found is None:
        raise UserError(f"unit {unit!r}: expected one of {', '.join(units.LENGTH_UNITS)}")
    length, factor = found
    if length == units.STEP:
        return float(factor)
    if scale is None or scale.length != length:
        has = f", the motor has {scale}" if scale else ": give motor or steps_per_unit"
        raise UserError(f"unit {unit!r}: needs steps per {length}{has}")
    return float(factor * scale.steps_per_unit)


@dataclass(frozen=True)
class _Asked:
    """What `make_line` is asked for, the way to the speed left out."""

    speed: int | str
    length: int | None
    hz: Fraction | None
    divider: int | None
    motor: Motor | None
    rule: str
    request: LineRequest

    @property
    def scale(self) -> Scale | None:
        """Steps per unit of the motor."""
        return given.scale(None, self.motor)

    def steps_px(self, hz: Fraction | None) -> int:
        """Return the speed in whole steps/pixel. Raises UserError if it is none."""
        found = given.quantity("speed", self.speed, units.SPEED, self.scale)
        given.needs_hz("speed", found, hz)
        return units.whole_speed(found, hz, self.scale, smooth=self.rule == SMOOTH)


@dataclass(frozen=True)
class _MadeCounts:
    """Counts on their way to a line."""

    made: GeneratedLine
    name: str
    hz: Fraction | None
    divider: int | None
    notes: tuple[str, ...]

    def line(self, asked: _Asked, name: str | None) -> MotionLine:
        """Return the line."""
        motor, rule = asked.motor, asked.rule
        sign = -1 if rule == PLAIN and motor and motor.negative else 1
        counts = tuple(sign * count for count in self.made.counts)
        negative = bool(motor and motor.negative and rule == SMOOTH)
        called = self.name if name is None else arguments.text("name", name)
        motion = Line(counts, rule, asked.request.backlash, negative, name=called)
        return MotionLine(motion, self.hz, motor, self.notes, self.made.image_pixel, self.divider)


def _profile(profile: Profile | None, motor: Motor | None) -> Profile:
    """Return the profile that is given, else the motor's."""
    if profile is not None:
        return arguments.instance("profile", profile, Profile, "a Profile")
    if motor is None or motor.profile is None:
        raise UserError("a line needs profile or max_acceleration")
    return read_profile(motor.profile)


def _by_profile(profile: Profile, asked: _Asked) -> _MadeCounts:
    """Make a line by a profile, whose speeds are per pixel."""
    if asked.length is not None:
        raise UserError("length: only with max_acceleration; by a profile pixels says it")
    motor = asked.motor
    hz = asked.hz or (motor.pixel_hz if motor else profile.pixel_hz)
    notes = [
        *profile.notes,
        *other_motor(Path(profile.name), None, motor),
        *_other_frequency(profile, hz),
    ]
    request = replace(asked.request, speed=asked.steps_px(hz))
    made = generator.generate(list(profile.speeds_steps_px), request, profile.name)
    return _MadeCounts(made, profile.name, hz, asked.divider, tuple(notes))


def _by_acceleration(
    acceleration: float | str, jerk: float | str | None, asked: _Asked
) -> _MadeCounts:
    """Make the shortest ramps within an acceleration, in pixels that allow it."""
    scale, motor = asked.scale, asked.motor
    if asked.hz is not None:
        clock_hz: Fraction = asked.hz
    elif motor is not None:
        clock_hz = motor.pixel_hz * motor.divider
    else:
        raise UserError("max_acceleration: needs a pixel frequency: pixel_hz or motor")
    wanted = accelerate.WantedLine(
        given.quantity("speed", asked.speed, units.SPEED, scale),
        given.quantity("max_acceleration", acceleration, units.ACCELERATION, scale),
        given.maybe(given.quantity, "max_jerk", jerk, units.JERK, scale),
        clock_hz,
        plain=asked.rule == PLAIN,
    )
    edges, divider = _edges(wanted, asked)
    made, _, notes = accelerate.line(wanted, edges, asked.length, asked.request, scale)
    notes = [note.partition(": divider")[0] for note in notes]
    return _MadeCounts(made, "line", clock_hz / edges, divider, tuple(notes))


def _edges(wanted: accelerate.WantedLine, asked: _Asked) -> tuple[int, int | None]:
    """Return the edges of a pixel by which the clock is divided here, and what a run is told."""
    motor = asked.motor
    if asked.hz is not None:  # the pixels are given
        accelerate.choose_divider(wanted)
        return 1, asked.divider
    if asked.divider is not None:
        return asked.divider, asked.divider
    if motor and wanted.allows(motor.divider):
        return motor.divider, motor.divider
    edges = accelerate.choose_divider(wanted)
    return edges, edges


def _other_frequency(profile: Profile, hz: Fraction | None) -> list[str]:
    """Return a note of a profile made for another frequency; refuse one for a lower one."""
    if hz is None or profile.pixel_hz is None or profile.pixel_hz == hz:
        return []
    other = origin.OtherFrequency(profile.name, profile.pixel_hz, hz)
    return [other.refuse_faster()]
