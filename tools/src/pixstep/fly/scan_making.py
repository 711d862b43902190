# SPDX-License-Identifier: MIT
"""Lines over the points of a scan, with a run-up before the first and a run-down after the last.

Run-up and run-down have as many pixels for all axes as the slowest of them needs. Where play has to
be taken up, the line begins with a pixel at rest, and reaches its speed two pixels before the first
point. What the motors cannot make is refused with axis, point and what fits.

The points of a scanspec: bounds, midpoints, and the pixels that each of them lasts.

A point has a lower bound, a midpoint and an upper bound of each axis, and a time: it becomes so
many pixels as the pixel clock has in that time, one if the spec gives no time. The load goes evenly
from bound to midpoint to bound.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from pixstep import arguments
from pixstep.api.machines import Motor
from pixstep.api.making import line_from_positions
from pixstep.api.words import Decode
from pixstep.errors import RefusedError, UserError
from pixstep.fly.scan_line import ScanLine
from pixstep.lazy import np, npt
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.line_check import Limits
from pixstep.lines.units import Scale
from pixstep.profiles.generator import MOST_PIXELS

if TYPE_CHECKING:
    Places = npt.NDArray[np.float64]


_WHOLE = 1e-6  # of a pixel: a point's time may be off by so much
_SAME = 1e-9  # of a scan's size: bounds that differ by less are the same


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


def axes_of(spec: Any) -> list[str]:
    """Return the names of the axes of a scanspec."""
    if not (hasattr(spec, "axes") and hasattr(spec, "frames")):
        raise UserError(f"spec {arguments.shown(spec)}: expected a spec of scanspec.specs")
    found = [str(name) for name in spec.axes() if str(name) != "DURATION"]
    if not found:
        raise UserError(f"spec {arguments.shown(spec)}: it has no axis")
    return found


def points_of(spec: Any, hz: Fraction) -> Points:
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
    return Points(lower, middle, upper, _pixels(frames, len(frames), hz))


def _pixels(frames: Any, count: int, hz: Fraction) -> tuple[int, ...]:
    """Return the pixels of each point."""
    if frames.duration is None:
        return (1,) * count
    exact = np.asarray(frames.duration, dtype=float) * float(hz)
    whole = np.maximum(1, np.rint(exact))
    wrong = np.flatnonzero(np.abs(exact - whole) > _WHOLE * whole)
    if len(wrong):
        point = int(wrong[0])
        low = max(1, int(exact[point]))
        raise RefusedError(
            f"point {point + 1}: {frames.duration[point]:.6g} s are {exact[point]:.6g} pixels at "
            f"{float(hz):.6g} Hz: what fits: {low / float(hz):.6g} s or "
            f"{(low + 1) / float(hz):.6g} s"
        )
    if whole.sum() > MOST_PIXELS:
        raise RefusedError(f"the scan has {whole.sum():.0f} pixels: what fits: {MOST_PIXELS}")
    return tuple(int(one) for one in whole)


_SLOWER = (2, 4, 8, 16, 32)  # times as many pixels a point, to say what fits
_MOST_TRIED = 20_000  # pixels of a slower scan, for that
_TRIES = 4  # run-ups that are tried, each half as long again as the one before
_EVEN_PIXELS = 2  # in which the speed swings in, so that all play is taken up


@dataclass(frozen=True)
class ScanDrive:
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


class TooFastError(RefusedError):
    """A line that might be made if its points took longer."""


class LatePlayError(RefusedError):
    """A line whose run-up does not take up the play."""


@dataclass(frozen=True)
class ScanLines:
    """The lines of some axes over the same points, as they are asked for."""

    points: Points
    drives: Sequence[ScanDrive]
    hz: Fraction
    run_up: int | None
    tolerance: float
    check: bool
    tries: int = _TRIES

    def that_fit(self) -> dict[str, ScanLine]:
        """Return the lines by axis. Raises RefusedError saying what fits."""
        for drive in self.drives:
            if drive.axis not in self.points.moving:
                raise RefusedError(
                    f"axis {drive.axis}: stands still at {self.points.lower[drive.axis][0]:.6g} in "
                    f"all points: what fits: move it there before, and leave it out"
                )
        try:
            return self._shortest()
        except TooFastError as error:
            raise RefusedError(f"{error}; what fits: {self._what_fits()}") from None

    def _shortest(self) -> dict[str, ScanLine]:
        """Return the lines by axis, with the shortest run-up that is tried and fits."""
        refusal: RefusedError | None = None
        for count in [self.run_up] if self.run_up is not None else self._run_ups():
            try:
                return {drive.axis: self._line(drive, count) for drive in self.drives}
            except (TooFastError, LatePlayError) as error:
                refusal = error
        assert refusal is not None
        raise refusal

    def _what_fits(self) -> str:
        """Return in words how slow the points have to be."""
        for times in _SLOWER:
            slower = replace(self, points=self.points.slower(times), tries=3)
            if sum(slower.points.pixels) > _MOST_TRIED:
                break
            with contextlib.suppress(RefusedError):
                slower._shortest()
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

    def _line(self, drive: ScanDrive, run_up: int) -> ScanLine:
        """Make the line of an axis with a run-up of so many pixels."""
        edges = self.points.edges(drive.axis)
        if drive.rule == SMOOTH:
            _refuse_turns(edges, drive, self.points)
        play = any(one.backlash for one in self.drives)
        before = _Before(int(play), run_up, _EVEN_PIXELS if play else 0)
        ways = _with_run_up(edges, before)
        # A motor stands on whole steps: so does the line's beginning.
        begins = round(ways[0] * drive.factor) / drive.factor
        ways[: before.rest + 1] = begins
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


def _run_up(edges: Places, drive: ScanDrive) -> int:
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
    return math.ceil(float(speed) / drive.acceleration)


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
    """Return positions with those of the run-up before and of the run-down after."""
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


def _refuse_turns(edges: Places, drive: ScanDrive, points: Points) -> None:
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
    ends = line.run_up + sum(line.point_pixels)
    for pixel in range(line.run_up, min(motion.shifted_pixels, ends)):
        lacking = motion.backlash * (1 - motion.speeds[pixel] / motion.line_speed)
        if lacking > most:
            raise LatePlayError(
                f"axis {line.scan_axis}: {_where(line, pixel + 1)}: {lacking:.3g} of "
                f"{motion.backlash} steps of play are not taken up before the highest speed, in "
                f"pixel {motion.shifted_pixels}: what fits: one speed in all points"
            )


def _refuse_findings(line: ScanLine, drive: ScanDrive, axes: int) -> None:
    """Raise RefusedError for what the motor or its board cannot make."""
    found = list(line.check(axes=axes).errors)
    if drive.acceleration:
        limits = Limits(max_acceleration=int(drive.acceleration)).with_rounding(line.line)
        found += line.check_by(limits).errors
    if found:
        first = min(found, key=lambda one: one.pixel)
        said = f"axis {line.scan_axis}: {_where(line, first.pixel)}: {first.message}"
        if first.name == "backlash_over_speed":
            raise RefusedError(
                f"{said}; what fits: {line.line.backlash} steps a pixel or more: faster points, or "
                f"a pixel clock of a lower frequency"
            )
        raise TooFastError(said)
