# SPDX-License-Identifier: MIT
"""Drawings of a plan: its path, and each motor's speed, acceleration and jerk with their limits."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pixstep import plotting
from pixstep.plotting import BOARD, FAINT, INK, MADE
from pixstep.programs.motors import PLAIN_ROUNDING, PlanMotor
from pixstep.programs.pixels import Counts
from pixstep.programs.plan import Plan

_MOST_POINTS = 20_000


@dataclass(frozen=True)
class Drawn:
    """A plan and the counts of its first pixels."""

    plan: Plan
    counts: Counts


def save(result: Drawn, path: Path, motion: Path) -> None:
    """Write both drawings."""
    with plotting.styled():
        plotting.write(draw_path(result), path)
        plotting.write(draw_motion(result), motion)


def draw_path(result: Drawn) -> Figure:
    """Return the path of the first two motors, or the position of the only one over time."""
    motors = result.plan.setup.motors
    places = np.vstack([np.zeros((1, len(motors))), np.cumsum(result.counts, axis=0)])
    scaled = places / np.array([motor.counts_per_unit for motor in motors])
    shown = scaled[:: _stride(len(scaled))]
    figure = plotting.figure((8, 8 if len(motors) > 1 else 4.5))
    axes = figure.add_subplot()
    if len(motors) > 1:
        axes.plot(shown[:, 0], shown[:, 1], ".-", color=MADE, lw=0.8, ms=3, mew=0)
        axes.plot(*scaled[0, :2], "o", color=INK, ms=5)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel(_label(motors[0]))
        axes.set_ylabel(_label(motors[1]))
    else:
        axes.plot(_times(result, len(scaled))[:: _stride(len(scaled))], shown[:, 0], color=MADE)
        axes.set_xlabel("time, s")
        axes.set_ylabel(_label(motors[0]))
    axes.set_title(f"{_title(result)}: positions at the pixel edges")
    return figure


def draw_motion(result: Drawn) -> Figure:
    """Return a row for each motor: its speed, its acceleration, and its jerk if that is limited.

    They are in counts and milliseconds, but the jerk, whose limit is one of whole pixels.
    """
    motors = result.plan.setup.motors
    keeps_jerk = result.plan.report.keeps_jerk
    figure = plotting.figure((15 if keeps_jerk else 11, 1.4 + 2.3 * len(motors)))
    rows = figure.subplots(len(motors), 3 if keeps_jerk else 2, sharex=True, squeeze=False)
    for index, (row, motor) in enumerate(zip(rows, motors, strict=True)):
        _draw_motor(row, result, index, motor)
    for axes in rows[-1]:
        axes.set_xlabel("time, s")
    what = "speeds, accelerations and jerks" if keeps_jerk else "speeds and accelerations"
    figure.suptitle(f"{_title(result)}: {what} with their limits", x=0.012, ha="left",
                    fontsize=13, weight="bold", color=INK)  # fmt: skip
    return figure


def _draw_motor(row: np.ndarray, result: Drawn, index: int, motor: PlanMotor) -> None:
    pixel = result.plan.setup.pixel_ms
    counts = result.counts[:, index]
    if motor.smooth:
        speeds = _decoded(counts)
        speed_times = _times(result, len(speeds))
        changes = np.diff(speeds)
    else:
        speeds = counts
        speed_times = _times(result, len(counts)) + pixel / 2000
        changes = np.diff(counts, prepend=0)
    stride = _stride(len(speeds))
    drawn = {"color": MADE, "lw": 1.0}
    row[0].plot(speed_times[::stride], speeds[::stride] / pixel, **drawn)
    row[1].step(_times(result, len(changes))[::stride], changes[::stride] / pixel**2,
                where="post", **drawn)  # fmt: skip
    _limit(row[0], motor.max_speed, float(np.abs(speeds).max()) / pixel)
    rounding = 0 if motor.smooth else PLAIN_ROUNDING / pixel**2
    _limit(row[1], motor.max_acceleration, float(np.abs(changes).max()) / pixel**2, rounding)
    row[0].set_ylabel(f"{motor.name}, counts/ms")
    row[1].set_ylabel("counts/ms²")
    if len(row) > 2:
        _draw_jerk(row[2], result, np.diff(changes, prepend=0), motor)


def _draw_jerk(axes: Axes, result: Drawn, jerks: np.ndarray, motor: PlanMotor) -> None:
    """Draw the jerk of whole steps, and the limit if the motor has one."""
    stride = _stride(len(jerks))
    axes.step(_times(result, len(jerks))[::stride], jerks[::stride], where="post", color=MADE,
              lw=1.0)  # fmt: skip
    if motor.max_jerk is not None:
        _limit(axes, motor.max_jerk, float(np.abs(jerks).max()), motor.jerk_rounding)
    axes.set_ylabel("jerk, steps/px³")


def _limit(axes: Axes, limit: float, peak: float, rounding: float = 0) -> None:
    """Draw a limit where it is in sight of what is drawn, else say it.

    Up to `rounding` above it is what whole steps may have.
    """
    if limit > 3 * max(peak, 1e-9):
        axes.set_title(f"limit {limit:.4g}", fontsize=8, color=FAINT)
        return
    for side in (limit, -limit):
        axes.axhline(side, color=BOARD, lw=0.9, ls="--")
    for side in (limit + rounding, -limit - rounding) if rounding else ():
        axes.axhline(side, color=FAINT, lw=0.8, ls=":")


def _decoded(counts: np.ndarray) -> np.ndarray:
    """Return the speeds at the pixel edges that the board finds."""
    speeds = [0]
    for count in counts.tolist():
        speeds.append(2 * count - speeds[-1])
    return np.array(speeds)


def _times(result: Drawn, count: int) -> np.ndarray:
    return np.arange(count) * result.plan.setup.pixel_ms / 1000


def _stride(count: int) -> int:
    return max(1, count // _MOST_POINTS)


def _label(motor: PlanMotor) -> str:
    return f"{motor.name}, {motor.unit}"


def _title(result: Drawn) -> str:
    return f"{Path(result.plan.name).name}, {result.plan.options.mode}"
