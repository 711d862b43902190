# SPDX-License-Identifier: MIT
"""Drawings of a plan: its path, and each motor's speed, acceleration and jerk with their limits."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pixstep import plotting
from pixstep.plotting import BOARD, IDEAL, INK, MADE, QUIET
from pixstep.profiles.ramps import decoded
from pixstep.programs.motors import PLAIN_ROUNDING, PlanMotor
from pixstep.programs.pixels import Counts
from pixstep.programs.plan import Plan

_MOST_POINTS = 20_000
_ARROWS = 6  # along the path


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
        _nominal(axes, result)
        axes.plot(shown[:, 0], shown[:, 1], ".-", color=MADE, lw=0.8, ms=3, mew=0,
                  label="planned, at the pixel edges")  # fmt: skip
        _arrows(axes, shown[:, :2])
        axes.plot(*scaled[0, :2], "o", color=INK, ms=5, label="start")
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, labelcolor=INK,
                    borderaxespad=0.2)  # fmt: skip
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel(_label(motors[0]))
        axes.set_ylabel(_label(motors[1]))
    else:
        axes.plot(_times(result, len(scaled))[:: _stride(len(scaled))], shown[:, 0], color=MADE)
        axes.set_xlabel("time, s")
        axes.set_ylabel(_label(motors[0]))
    figure.suptitle(f"{_title(result)}: the path", x=0.012, ha="left", fontsize=13, weight="bold",
                    color=INK)  # fmt: skip
    return plotting.write_numbers(figure)


def _nominal(axes: Axes, result: Drawn) -> None:
    """Draw the moves as the program has them, corner to corner, under the path."""
    motors = result.plan.setup.motors[:2]
    corners = np.array([(0.0,) * len(motors), *(place[:2] for place in result.plan.corners)])
    scaled = corners / np.array([motor.counts_per_unit for motor in motors])
    axes.plot(scaled[:, 0], scaled[:, 1], color=IDEAL, lw=5, alpha=0.55, label="programmed")


def _arrows(axes: Axes, places: np.ndarray) -> None:
    """Draw arrows along the path, as far apart as it is long."""
    way = np.append(0, np.cumsum(np.hypot(*np.diff(places, axis=0).T)))
    for share in (np.arange(_ARROWS) + 0.5) / _ARROWS:
        end = int(np.searchsorted(way, share * way[-1]))
        if way[-1] > 0 and end and np.any(places[end] != places[end - 1]):
            axes.annotate("", xy=places[end], xytext=places[end - 1],
                          arrowprops={"arrowstyle": "-|>", "color": MADE, "lw": 1.2,
                                      "mutation_scale": 16})  # fmt: skip


def draw_motion(result: Drawn) -> Figure:
    """Return a row for each motor: its speed, its acceleration, and its jerk if that is limited.

    They are in the motor's unit and seconds, but the jerk, whose limit is one of whole pixels.
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
    handles = [
        Line2D([], [], color=MADE, lw=1.4, label="planned, in whole steps"),
        Line2D([], [], color=BOARD, lw=0.9, ls="--", label="limit"),
    ]
    figure.legend(handles=handles, loc="outside upper right", ncols=2, labelcolor=INK)
    figure.align_ylabels()
    return plotting.write_numbers(figure)


def _draw_motor(row: np.ndarray, result: Drawn, index: int, motor: PlanMotor) -> None:
    pixel = result.plan.setup.pixel_ms
    counts = result.counts[:, index]
    if motor.smooth:
        speeds = np.array([0, *decoded(0, tuple(counts.tolist()))])
        speed_times = _times(result, len(speeds))
        changes = np.diff(speeds)
    else:
        speeds = counts
        speed_times = _times(result, len(counts)) + pixel / 2000
        changes = np.diff(counts, prepend=0)
    stride = _stride(len(speeds))
    drawn = {"color": MADE, "lw": 1.0}
    per_s = 1000 / motor.counts_per_unit  # of counts/ms
    per_s2 = 1000 * per_s
    row[0].plot(speed_times[::stride], speeds[::stride] / pixel * per_s, **drawn)
    most = motor.max_acceleration * pixel**2
    shown = changes if motor.smooth else _without_rounding(changes, most)
    row[1].step(_times(result, len(shown))[::stride], shown[::stride] / pixel**2 * per_s2,
                where="post", **drawn)  # fmt: skip
    _limit(row[0], motor.max_speed * per_s, float(np.abs(speeds).max()) / pixel * per_s)
    peak = float(np.abs(shown).max()) / pixel**2
    _limit(row[1], motor.max_acceleration * per_s2, peak * per_s2)
    row[0].set_ylabel(f"{motor.name}, {motor.unit}/s")
    row[1].set_ylabel(f"{motor.unit}/s²")
    if len(row) > 2:
        _draw_jerk(row[2], result, np.diff(changes, prepend=0), motor)


def _without_rounding(changes: np.ndarray, most: float) -> np.ndarray:
    """Return the changes of a plain motor's counts without what whole steps add to the limit.

    Two counts are whole, so their difference may be PLAIN_ROUNDING above the planned acceleration,
    which is within the limit. What is further above is drawn as it is.
    """
    rounded = (np.abs(changes) > most) & (np.abs(changes) <= most + PLAIN_ROUNDING)
    return np.where(rounded, np.sign(changes) * most, changes)


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
        text = f"limit {plotting.figures(limit)}, out of the picture"
        axes.set_title(text, loc="right", fontsize=8.5, weight="normal", color=BOARD)
        return
    for side in (limit, -limit):
        axes.axhline(side, color=BOARD, lw=0.9, ls="--")
    for side in (limit + rounding, -limit - rounding) if rounding else ():
        axes.axhline(side, color=QUIET, lw=0.8, ls=":")


def _times(result: Drawn, count: int) -> np.ndarray:
    return np.arange(count) * result.plan.setup.pixel_ms / 1000


def _stride(count: int) -> int:
    return max(1, count // _MOST_POINTS)


def _label(motor: PlanMotor) -> str:
    return f"{motor.name}, {motor.unit}"


def _title(result: Drawn) -> str:
    return f"{Path(result.plan.name).name}, {result.plan.options.mode}"
