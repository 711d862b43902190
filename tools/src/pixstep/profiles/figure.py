# SPDX-License-Identifier: MIT
"""One figure of a line: speed, acceleration, jerk and position over the same pixel axis."""

from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from pixstep import atomic, plotting, progress
from pixstep.errors import UserError
from pixstep.lines import units
from pixstep.plotting import BOARD, FAINT, INK, MADE, QUIET, WARM
from pixstep.profiles import kinematics, marks
from pixstep.profiles.drawing import Drawing

SUFFIXES = (".png", ".svg", ".pdf")
_DENSE = 240  # pixels from which single marks would run together
_PER_SECOND = {1: "/s", 2: "/s²", 3: "/s³"}
_FAR = 3  # a limit so many times the peak is said, not drawn: the curve would be flat beside it


def save(drawing: Drawing, path: Path) -> None:
    """Write the figure in the format of the suffix. Raises UserError for an unknown suffix."""
    if path.suffix.lower() not in SUFFIXES and not atomic.is_stream(path):
        raise UserError(f"{path}: a drawing ends with {', '.join(SUFFIXES)}")
    below = {"axes.axisbelow": True}
    with progress.shown("drawing") as progressed, plotting.styled(**below):
        figure = build(drawing)
        progressed(0.5)
        plotting.write(figure, path)


def build(drawing: Drawing) -> Figure:
    """Return the figure; its axes are labelled phases, speed, acceleration, jerk, position."""
    figure = plotting.figure((11, 9.4))
    rows = figure.subplots(5, 1, sharex=True, height_ratios=[0.16, 1.5, 1, 0.9, 1.2])
    motion = drawing.motion
    lane, speed, acceleration, jerk, position = rows
    _speed(speed, motion)
    _acceleration(acceleration, motion, drawing.limits.get(units.ACCELERATION))
    _jerk(jerk, motion, drawing.limits.get(units.JERK))
    _position(position, motion)
    plotting.lengths(position, drawing.scale)
    panels = (speed, acceleration, jerk, position)
    for order, axes in enumerate(panels[:3], 1):
        _limit(axes, drawing, order)
        _second_scale(axes, drawing, order)
    meanings = marks.add(panels, drawing.line, drawing.image_pixel)
    marks.lane(lane, drawing.line)
    plotting.time_axis(position, drawing.pixel_hz)
    edge = 0.006 * drawing.line.pixels  # so that marks at both ends are whole
    position.set_xlim(-edge, drawing.line.pixels + edge)
    position.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))
    figure.align_ylabels(panels)
    _captions(figure, drawing, meanings)
    return plotting.write_numbers(figure)


def _captions(figure: Figure, drawing: Drawing, meanings: list[Artist]) -> None:
    """Put the title on top and what the marks mean at the bottom."""
    if not all(_is_far(drawing, order) for order in drawing.limits):
        limit = Line2D([], [], color=BOARD, lw=1.1, ls=(0, (5, 3)), label="limit")
        meanings = [limit, *meanings]
    figure.suptitle(f"{drawing.title}\n", x=0.012, ha="left", fontsize=14, weight="bold", color=INK)
    figure.text(0.012, 0.957, drawing.subtitle, fontsize=9.5, color=QUIET, va="top")
    if meanings:
        longest = max(len(str(one.get_label())) for one in meanings)
        columns = max(1, 160 // (longest + 10))  # characters that fit, and room for a mark
        figure.legend(handles=meanings, loc="outside lower left", ncols=columns,
                      labelcolor=INK, fontsize=9)  # fmt: skip


def _panel(axes: Axes, name: str, unit: str) -> None:
    axes.set_label(name)
    axes.set_ylabel(unit)
    axes.set_title(name.capitalize())
    axes.margins(y=0.1)


def _speed(axes: Axes, motion: kinematics.Kinematics) -> None:
    _panel(axes, "speed", units.unit(units.SPEED))
    times, speeds = motion.corners
    axes.fill_between(times, speeds, color=MADE, alpha=0.10, lw=0)
    axes.plot(times, speeds, color=MADE, lw=1.8, gid="speed")
    if motion.line.smooth and motion.line.pixels <= _DENSE:
        axes.plot(motion.edges_px, np.append(motion.begin_speeds, motion.end_speeds[-1]), ".",
                  color=MADE, ms=5, clip_on=False, gid="boundary speeds")  # fmt: skip
    if np.min(speeds, initial=0) >= 0:
        axes.set_ylim(0, 1.1 * max(1, np.max(speeds)))


def _acceleration(axes: Axes, motion: kinematics.Kinematics, limit: int | None) -> None:
    _panel(axes, "acceleration", "steps/px²")
    if motion.line.smooth:
        axes.stairs(motion.accelerations, motion.edges_px, fill=True, color=WARM, alpha=0.15)
        axes.stairs(motion.accelerations, motion.edges_px, color=WARM, lw=1.8, baseline=None,
                    gid="acceleration")  # fmt: skip
        axes.axhline(0, color=FAINT, lw=0.8)
    else:
        _stems(axes, motion.edges_px, motion.speed_changes, WARM, limit)


def _jerk(axes: Axes, motion: kinematics.Kinematics, limit: int | None) -> None:
    _panel(axes, "jerk", "steps/px³")
    _stems(axes, motion.edges_px, motion.jerks, INK, limit)


def _stems(
    axes: Axes, times: np.ndarray, values: np.ndarray, colour: str, limit: int | None
) -> None:
    """Draw changes at pixel edges; a zero change is no stem, one beyond the limit stands out."""
    dense = len(times) > _DENSE
    beyond = np.abs(values) > (np.inf if limit is None else limit)
    axes.axhline(0, color=FAINT, lw=0.8)
    for shown, ink, name in ((~beyond & (values != 0), colour, "kept"), (beyond, BOARD, "beyond")):
        axes.vlines(times[shown], 0, values[shown], color=ink, lw=0.8 if dense else 1.6)
        axes.plot(times[shown], values[shown], "o", color=ink, ms=0 if dense else 3.2,
                  gid=f"{axes.get_label()} {name}")  # fmt: skip


def _position(axes: Axes, motion: kinematics.Kinematics) -> None:
    _panel(axes, "position", "steps")
    times, steps = motion.curve()
    axes.plot(times, steps, color=MADE, lw=1.8, gid="position")
    if motion.line.pixels <= _DENSE:
        axes.plot(motion.edges_px, motion.positions, ".", color=MADE, ms=5)


def _limit(axes: Axes, drawing: Drawing, order: int) -> None:
    """Draw a limit, on both sides where the figure has both signs; say one that is far away."""
    limit = drawing.limits.get(order)
    if limit is None:
        return
    name = f"limit {plotting.number(limit)}"
    if _is_far(drawing, order):
        axes.set_title(f"{name}, out of the picture", loc="right", fontsize=8.5, color=BOARD)
        return
    low, high = axes.dataLim.intervaly
    for value in (limit, -limit) if low < 0 else (limit,):
        axes.axhline(value, color=BOARD, lw=1.1, ls=(0, (5, 3)), gid=f"limit {axes.get_label()}")
    top = max(high, limit)
    bottom = min(low, -limit) if low < 0 else 0
    space = 0.12 * (top - bottom)
    axes.set_ylim(bottom - space if low < 0 else 0, top + 1.6 * space)
    axes.text(0.5, limit, name, ha="center", va="center",
              transform=axes.get_yaxis_transform(), fontsize=8.5, color=BOARD,
              bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5})  # fmt: skip


def _is_far(drawing: Drawing, order: int) -> bool:
    """True for a limit far above everything that the line does."""
    figures = drawing.figures
    peaks = {
        units.SPEED: figures.peak_speed,
        units.ACCELERATION: figures.peak_acceleration,
        units.JERK: figures.peak_jerk,
    }
    return drawing.limits[order] > _FAR * peaks[order] > 0


def _second_scale(axes: Axes, drawing: Drawing, order: int) -> None:
    """Put the same figures per second on the right, as lengths where the scale is known."""
    if drawing.pixel_hz is None:
        return
    factor = float(drawing.pixel_hz) ** order
    if drawing.scale:
        plotting.lengths(axes, drawing.scale, _PER_SECOND[order], factor)
        return
    functions = (lambda y: np.multiply(y, factor), lambda y: np.divide(y, factor))
    scale = axes.secondary_yaxis("right", functions=functions)
    scale.set_ylabel(units.unit(order, per_second=True).replace("2", "²").replace("3", "³"))
    scale.spines["right"].set_visible(True)
    scale.spines["right"].set_color("#dfe5ea")
