# SPDX-License-Identifier: MIT
"""The points of a scanspec: bounds, midpoints, and the pixels that each of them lasts.

A point has a lower bound, a midpoint and an upper bound of each axis, and a time: it becomes so
many pixels as the pixel clock has in that time, one if the spec gives no time. The load goes evenly
from bound to midpoint to bound.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from pixstep import arguments
from pixstep.errors import RefusedError, UserError
from pixstep.lazy import np, npt
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
