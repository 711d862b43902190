# SPDX-License-Identifier: MIT
"""Lines that fly over the points of a scanspec, without a stop from the first to the last.

A point of a scanspec has a lower bound, a midpoint and an upper bound of each axis, and a time: it
becomes so many pixels as the pixel clock has in that time, one if the spec gives no time. The load
goes evenly from bound to midpoint to bound. Before the first point it speeds up, behind the last
one it slows down: run-up and run-down have as many pixels for all axes as the slowest of them
needs.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from pixstep import arguments
from pixstep.api import given
from pixstep.api.given import Hz
from pixstep.api.machines import Motor
from pixstep.api.making import line_from_positions, steps_of
from pixstep.api.words import Decode
from pixstep.errors import RefusedError, UserError
from pixstep.fly.scan_line import ScanLine
from pixstep.lazy import lazy
from pixstep.lines import units
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.line_check import Limits
from pixstep.lines.units import Scale
from pixstep.profiles.generator import MOST_PIXELS

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Places = npt.NDArray[np.float64]
else:
    np, npt = lazy("numpy"), lazy("numpy.typing")

DEVIATION_STEPS = 2.0
_MOST_TRIED = 20_000  # pixels of a slower scan, for that
_TRIES = 4  # run-ups that are tried, each half as long again as the one before
_EVEN_PIXELS = 2  # in which the speed swings in, so that all play is taken up
_WHOLE = 1e-6  # of a pixel: a point's time may be off by so much
_SAME = 1e-9  # of a scan's size: bounds that differ by less are the same
_SLOWER = (2, 4, 8, 16, 32)  # times as many pixels a point, to say what fits


@dataclass(frozen=True)
class Drive:
    """What moves an axis of a scan, and how it is to fly."""

    axis: str
    motor: Motor | None
    rule: Decode
    unit: str
    scale: Scale | None
    factor: float
    """The motor's steps for one unit, signed."""
    backlash: int
    acceleration: float
    """Largest, steps/pixel2; 0 if none is known."""


@dataclass(frozen=True)
class Points:
    """The points of a scan: bounds and midpoints by axis, and the pixels of each point."""

    lower: Mapping[str, Places]
    middle: Mapping[str, Places]
    upper: Mapping[str, Places]
    pixels: tuple[int, ...]

    def edges(self, axis: str) -> Places:
        """Return where an axis is at each pixel's edge, from the first point's lower bound on."""
        found = [self.lower[axis][:1]]
        for low, mid, high, count in zip(
            self.lower[axis], self.middle[axis], self.upper[axis], self.pixels, strict=True
        ):
            parts = np.arange(1, count + 1) / count
            found.append(np.interp(parts, (0.0, 0.5, 1.0), (low, mid, high)))
        return np.concatenate(found)

    @property
    def moving(self) -> list[str]:
        """The axes that do not stand still in all points."""
        bounds = {axis: np.concatenate([self.lower[axis], self.upper[axis]]) for axis in self.lower}
        return [axis for axis, found in bounds.items() if np.any(found != found[0])]

    def slower(self, times: int) -> Points:
        """Return the same points with so many times as many pixels."""
        return replace(self, pixels=tuple(times * count for count in self.pixels))


def line_from_scanspec(
    spec: Any,
    *,
    motor: Motor | None = None,
    axis: str | None = None,
    pixel_hz: Hz | None = None,
    unit: str | None = None,
    steps_per_unit: str | Scale | None = None,
    decode: Decode | None = None,
    backlash: int | str | None = None,
    max_acceleration: float | str | None = None,
    run_up: int | str | None = None,
    max_deviation: float = DEVIATION_STEPS,
    check: bool = True,
) -> ScanLine:
    """Make the line of one axis that flies over the points of a scanspec.

    `axis` is needed if the spec has several. Positions are in `unit`, by default mm or degrees as
    the motor's scale has it (`steps_per_unit` without a motor), else steps. A point lasts as long
    as the spec says, in whole pixels; one pixel if the spec says nothing. `run_up` are the pixels
    before the first point and behind the last; without it as many as `max_acceleration`
    (steps/pixel2, or `"500 mm/s2"`, by default the motor's) needs. In the points the line is at
    most `max_deviation` steps from the scan at any pixel's edge. `check` refuses a line that the
    motor or its board could not make. The line knows where it begins (`start`) and which pixels are
    which point's (`points_of`). Raises UserError or RefusedError with axis, point and what fits:
    for gaps between points, for an axis that stands still, for a point that is no whole number of
    pixels, for a smooth motor that would turn back.
    """
    names = _axes_of(spec)
    if axis is None:
        if len(names) > 1:
            raise UserError(f"axis: the spec has {', '.join(names)}: give one of them")
        axis = names[0]
    elif axis not in names:
        raise UserError(f"axis {arguments.shown(axis)}: the spec has {', '.join(names)}")
    hz = given.exact_hz(pixel_hz) or (given.motor(motor).pixel_hz if motor else None)
    drive = _drive(axis, motor, unit, steps_per_unit, decode, backlash, max_acceleration, hz)
    making = _making(spec, [drive], hz, run_up, max_deviation, check=check)
    return making.lines_that_fit()[axis]


def lines_from_scanspec(
    spec: Any,
    motors: Mapping[str, Motor],
    *,
    max_acceleration: Mapping[str, float | str] | None = None,
    run_up: int | str | None = None,
    max_deviation: float = DEVIATION_STEPS,
    check: bool = True,
) -> dict[str, ScanLine]:
    """Make the lines of several axes that fly together, by the axes' names in the scanspec.

    `motors` are those of the axes, of one machine file. An axis of the spec that stands still needs
    none; each other one does. All lines have the same run-up and so the same pixels. The rest is as
    `line_from_scanspec` has it.
    """
    if not isinstance(motors, Mapping) or not motors:
        raise UserError(f"motors {arguments.shown(motors)}: expected motors by axis of the spec")
    names = _axes_of(spec)
    for name in motors:
        if name not in names:
            raise UserError(f"axis {arguments.shown(name)}: the spec has {', '.join(names)}")
    rates = {given.exact_hz(motor.pixel_hz) for motor in motors.values()}
    if len(rates) > 1:
        raise UserError("motors: of machines with several pixel frequencies: one clock drives all")
    hz = rates.pop()
    limits = max_acceleration or {}
    drives = [
        _drive(name, motor, None, None, None, None, limits.get(name), hz)
        for name, motor in motors.items()
    ]
    making = _making(spec, drives, hz, run_up, max_deviation, check=check)
    for name in making.points.moving:
        if name not in motors:
            raise UserError(f"axis {name}: moves in the spec, and has no motor: give it one")
    return making.lines_that_fit()


def _axes_of(spec: Any) -> list[str]:
    """Return the names of the axes of a scanspec."""
    if not (hasattr(spec, "axes") and hasattr(spec, "frames")):
        raise UserError(f"spec {arguments.shown(spec)}: expected a spec of scanspec.specs")
    found = [str(name) for name in spec.axes() if str(name) != "DURATION"]
    if not found:
        raise UserError(f"spec {arguments.shown(spec)}: it has no axis")
    return found


def _drive(
    axis: str,
    motor: Motor | None,
    unit: str | None,
    steps_per_unit: str | Scale | None,
    decode: Decode | None,
    backlash: int | str | None,
    acceleration: float | str | None,
    hz: Fraction | None,
) -> Drive:
    motor = given.motor(motor)
    rule = given.decode(decode, motor)
    scale = given.scale(steps_per_unit, motor)
    named = unit or (scale.length if scale else "steps")
    factor = steps_of(arguments.text("unit", named), scale)
    if acceleration is None:
        limit = motor.limits.max_acceleration if motor else None
        most = Fraction(limit or 0)
    else:
        found = given.quantity("max_acceleration", acceleration, units.ACCELERATION, scale)
        most = given.needs_hz("max_acceleration", found, hz).per_pixel(hz)
    sign = -1 if motor and motor.negative else 1
    return Drive(
        axis, motor, rule, named, scale, sign * factor, given.backlash(backlash, rule, motor), float(most)
    )


def _making(
    spec: Any,
    drives: Sequence[Drive],
    hz: Fraction | None,
    run_up: int | str | None,
    max_deviation: float,
    *,
    check: bool,
) -> _Making:
    """Return what makes the lines of some axes."""
    if hz is None:
        raise UserError("a scan's line needs a pixel frequency: pixel_hz or motor")
    return _Making(
        _points(spec, hz, drives), drives, hz,
        None if run_up is None else given.pixels("run_up", run_up),
        arguments.finite("max_deviation", max_deviation, 0),
        check=arguments.flag("check", check),
    )  # fmt: skip


class TooFastError(RefusedError):
    """A line that might be made if its points took longer."""


class LatePlayError(RefusedError):
    """A line whose run-up does not take up the play."""


@dataclass(frozen=True)
class _Making:
    """Lines of some axes over the same points."""

    points: Points
    drives: Sequence[Drive]
    hz: Fraction
    run_up: int | None
    tolerance: float
    check: bool
    tries: int = _TRIES

    def lines_that_fit(self) -> dict[str, ScanLine]:
        """Return the lines by axis. Raises RefusedError saying what fits."""
        try:
            return self.lines()
        except TooFastError as error:
            raise RefusedError(f"{error}; what fits: {self.what_fits()}") from None

    def lines(self) -> dict[str, ScanLine]:
        """Return the lines by axis, with the shortest run-up that is tried and fits."""
        refusal: RefusedError | None = None
        for count in [self.run_up] if self.run_up is not None else self._run_ups():
            try:
                return {drive.axis: self._line(drive, count) for drive in self.drives}
            except (TooFastError, LatePlayError) as error:
                refusal = error
        assert refusal is not None
        raise refusal

    def what_fits(self) -> str:
        """Return in words how slow the points have to be."""
        for times in _SLOWER:
            slower = replace(self, points=self.points.slower(times), tries=3)
            if sum(slower.points.pixels) > _MOST_TRIED:
                break
            with contextlib.suppress(RefusedError):
                slower.lines()
                seconds = slower.points.pixels[0] / float(self.hz)
                return f"{times} times as many pixels, {seconds:.6g} s in the first point"
        return "slower points, or changes of speed spread over more of them"

    def _run_ups(self) -> list[int]:
        """Return the pixels of run-ups that are tried, the shortest first."""
        least = max(_run_up(self.points.edges(drive.axis), drive) for drive in self.drives)
        found = [least]
        while len(found) < self.tries and least:
            found.append(max(found[-1] + 1, found[-1] * 3 // 2))
        return found

    def _line(self, drive: Drive, run_up: int) -> ScanLine:
        """Make the line of an axis with a run-up of so many pixels."""
        edges = self.points.edges(drive.axis)
        if drive.rule == SMOOTH:
            _refuse_turns(edges, drive, self.points)
        play = any(one.backlash for one in self.drives)
        before = _Before(int(play), run_up, _EVEN_PIXELS if play else 0)
        ways = _with_run_up(edges, before)
        made = line_from_positions(
            ways, unit=drive.unit, motor=drive.motor, pixel_hz=self.hz, decode=drive.rule,
            steps_per_unit=drive.scale, backlash=drive.backlash, name=f"axis {drive.axis}",
        )  # fmt: skip
        first = before.pixels
        line = ScanLine(
            made.line, made.pixel_hz, made.motor, made.notes, first + 1, made.divider,
            made.deviation_steps, scan_axis=drive.axis, unit=drive.unit,
            steps_per_unit=drive.factor, start=float(ways[0]), end=float(ways[-1]),
            point_pixels=self.points.pixels, run_up=first,
        )  # fmt: skip
        _refuse_deviation(line, edges, self.tolerance)
        _refuse_late_play(line, self.tolerance)
        if self.check:
            _refuse_findings(line, drive, len(self.drives))
        return line


def _run_up(edges: Places, drive: Drive) -> int:
    """Return the pixels that an axis needs to its speed in the first point, or from the last."""
    steps = edges * drive.factor
    speed = max(abs(steps[1] - steps[0]), abs(steps[-1] - steps[-2]))
    at_once = (drive.motor.limits.start_stop or 0) if drive.motor else 0
    if not speed or (drive.rule == PLAIN and speed <= at_once):
        return 0
    if not drive.acceleration:
        raise UserError(
            f"axis {drive.axis}: give max_acceleration, or run_up in pixels: no machine file says "
            f"its motor's max_acceleration"
        )
    return math.ceil(speed / drive.acceleration)


@dataclass(frozen=True)
class _Before:
    """Pixels before the first point: at rest, where play is taken up; gaining speed; at speed."""

    rest: int
    ramp: int
    even: int

    @property
    def pixels(self) -> int:
        """All of them."""
        return self.rest + self.ramp + self.even


def _with_run_up(edges: Places, before: _Before) -> Places:
    """Return positions with those of the run-up before and of the run-down behind."""
    first, last = edges[1] - edges[0], edges[-1] - edges[-2]
    even = edges[0] - first * np.arange(before.even, 0, -1)
    edges = np.concatenate([even, edges])
    if before.ramp:
        ramp = np.arange(before.ramp + 1) ** 2 / (2 * before.ramp)  # from rest to the speed 1
        faster = edges[0] + first * (ramp - ramp[-1])
        slower = edges[-1] + last * (ramp[-1] - ramp[::-1])
        edges = np.concatenate([faster[:-1], edges, slower[1:]])
    return np.concatenate([edges[:1]] * before.rest + [edges])


def _where(line: ScanLine, pixel: int) -> str:
    """Return the point of a pixel, from 1, in words."""
    point = int(line.points_of([pixel])[0])
    if point:
        return f"point {point} (pixel {pixel})"
    return f"{'run-up' if pixel <= line.run_up else 'run-down'} (pixel {pixel})"


def _refuse_turns(edges: Places, drive: Drive, points: Points) -> None:
    """Raise RefusedError where a smooth motor would turn back."""
    moves = np.sign(np.diff(edges))
    first = moves[np.flatnonzero(moves)[0]]
    back = np.flatnonzero(moves == -first)
    if len(back):
        point = int(np.searchsorted(np.cumsum(points.pixels), back[0], side="right")) + 1
        raise RefusedError(
            f"axis {drive.axis}: point {point}: turns back at {edges[back[0]]:.6g} {drive.unit}, "
            f"the line of a smooth motor has one direction: what fits: a line for each direction"
        )


def _refuse_deviation(line: ScanLine, edges: Places, most: float) -> None:
    """Raise RefusedError where a line is too far from its points."""
    steps = line.line.direction * np.cumsum((0, *line.counts))
    at = steps[line.run_up : line.run_up + len(edges)]
    wanted = (edges - line.start) * line.steps_per_unit
    off = np.abs(at - wanted)
    worst = int(np.argmax(off))
    if off[worst] > most:
        pixel = line.run_up + max(1, worst)
        in_unit = off[worst] / abs(line.steps_per_unit)
        raise TooFastError(
            f"axis {line.scan_axis}: {_where(line, pixel)}: the nearest line of the motor is "
            f"{off[worst]:.3g} steps ({in_unit:.3g} {line.unit}) beside the scan, max_deviation is "
            f"{most:g}"
        )


def _refuse_late_play(line: ScanLine, most: float) -> None:
    """Raise RefusedError where play is still taken up in the points.

    A board takes it up while the line gains speed, in proportion, and is done with it at the
    highest speed.
    """
    motion = line.line
    behind = line.run_up + sum(line.point_pixels)
    for pixel in range(line.run_up, min(motion.shifted_pixels, behind)):
        lacking = motion.backlash * (1 - motion.speeds[pixel] / motion.line_speed)
        if lacking > most:
            raise LatePlayError(
                f"axis {line.scan_axis}: {_where(line, pixel + 1)}: {lacking:.3g} of "
                f"{motion.backlash} steps of play are not taken up before the highest speed, in "
                f"pixel {motion.shifted_pixels}: what fits: one speed in all points"
            )


def _refuse_findings(line: ScanLine, drive: Drive, axes: int) -> None:
    """Raise RefusedError for what the motor or its board cannot make."""
    found = list(line.check(axes=axes).errors)
    if drive.acceleration:
        limits = Limits(max_acceleration=int(drive.acceleration)).with_rounding(line.line)
        found += line.check_by(limits).errors
    if found:
        first = min(found, key=lambda one: one.pixel)
        raise TooFastError(f"axis {line.scan_axis}: {_where(line, first.pixel)}: {first.message}")


def _points(spec: Any, hz: Fraction, drives: Sequence[Drive]) -> Points:
    """Return the points of a spec. Raises RefusedError for what no line flies over at one go."""
    frames = spec.frames(bounds=True)
    size = {str(key): float(np.ptp(values)) or 1.0 for key, values in frames.upper.items()}
    lower, middle, upper = (
        {str(key): np.asarray(values, dtype=float) for key, values in part.items()}
        for part in (frames.lower, frames.midpoints, frames.upper)
    )
    for axis in lower:
        before, behind = upper[axis][:-1], lower[axis][1:]
        gaps = np.flatnonzero(np.abs(before - behind) > _SAME * size[axis])
        if len(gaps):
            first = int(gaps[0])
            raise RefusedError(
                f"axis {axis}: point {first + 2}: begins at {behind[first]:.6g}, the point before "
                f"ends at {before[first]:.6g}: a line has no gaps; what fits: points that join, "
                f"and a line of its own for each row of a scan of several dimensions"
            )
    points = Points(lower, middle, upper, _pixels(frames, len(frames), hz))
    for drive in drives:
        if drive.axis not in points.moving:
            raise RefusedError(
                f"axis {drive.axis}: stands still at {lower[drive.axis][0]:.6g} in all points: "
                f"what fits: move it there before, and leave it out"
            )
    return points


def _pixels(frames: Any, count: int, hz: Fraction) -> tuple[int, ...]:
    """Return the pixels of each point."""
    if frames.duration is None:
        return (1,) * count
    exact = np.asarray(frames.duration, dtype=float) * float(hz)
    whole = np.maximum(1, np.rint(exact))
    wrong = np.flatnonzero(np.abs(exact - whole) > _WHOLE * whole)
    if len(wrong):
        point = int(wrong[0])
        low = max(1, math.floor(exact[point]))
        raise RefusedError(
            f"point {point + 1}: {frames.duration[point]:.6g} s are {exact[point]:.6g} pixels at "
            f"{float(hz):.6g} Hz: what fits: {low / float(hz):.6g} s or "
            f"{(low + 1) / float(hz):.6g} s"
        )
    if whole.sum() > MOST_PIXELS:
        raise RefusedError(f"the scan has {whole.sum():.0f} pixels: what fits: {MOST_PIXELS}")
    return tuple(int(one) for one in whole)
