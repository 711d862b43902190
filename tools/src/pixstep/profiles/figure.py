# SPDX-License-Identifier: MIT
"""One figure of a line: speed, acceleration, jerk and position over the same pixel axis.

Above them is a strip of the line's phases, by what the motor does in them; its marks are the
backlash take-up, the image start and oscillations.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from pixstep import atomic, plotting, progress
from pixstep.errors import UserError
from pixstep.lines import line_check, units
from pixstep.lines.line import Line
from pixstep.plotting import BOARD, FAINT, INK, MADE, QUIET, WARM
from pixstep.profiles import kinematics
from pixstep.profiles.kinematics import LineDrawing

REST, UP, CONSTANT, DOWN, SWING, TAKE_UP = "rest", "up", "constant", "down", "swing", "take-up"


@dataclass(frozen=True)
class Phase:
    """From `begin` to `end` in pixel periods; a name, and a shorter one."""

    kind: str
    begin: float
    end: float
    text: str
    short: str


def phases(line: Line) -> list[Phase]:
    """Return the phases of a line in order, without gaps."""
    motion = kinematics.of(line)
    kinds = list(_kinds(line, motion))
    phases = []
    first = 0
    for (kind, speeds), group in groupby(kinds):
        behind = first + len(list(group))
        begin, end = float(motion.edges_px[first]), float(motion.edges_px[behind])
        phases.append(Phase(kind, begin, end, *_texts(kind, speeds)))
        first = behind
    return phases


def _kinds(line: Line, motion: kinematics.LineKinematics) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Yield the kind of every piece, with the speeds that tell it from another of its kind."""
    swings: dict[int, tuple[int, int]] = {}
    for run in line_check.oscillations(line) if line.smooth else ():
        swings |= dict.fromkeys(range(run.pixel - 1, run.pixel - 1 + run.length), run.swing)
    changes = motion.accelerations if line.smooth else motion.speed_changes
    for piece, speed in enumerate(motion.begin_speeds.tolist()):
        take_up = bool(line.shifted_pixels) and piece == line.shifted_pixels
        pixel = piece - int(bool(line.shifted_pixels) and piece > line.shifted_pixels)
        if take_up:
            yield TAKE_UP, ()
        elif pixel in swings:
            yield SWING, swings[pixel]
        else:
            yield _kind(line, int(changes[piece]), speed, int(motion.end_speeds[piece]))


def _kind(line: Line, change: int, begin: int, end: int) -> tuple[str, tuple[int, ...]]:
    """Return the kind of a piece that neither swings nor takes up backlash."""
    if begin == 0 and end == 0:
        return REST, ()
    if not line.smooth or change == 0:
        return CONSTANT, (begin,)
    faster = abs(end) > abs(begin)
    return (UP if faster else DOWN), ()


def _texts(kind: str, speeds: tuple[int, ...]) -> tuple[str, str]:
    numbers = [plotting.number(speed) for speed in speeds]
    if kind == CONSTANT:
        return f"constant {numbers[0]}", numbers[0]
    if kind == SWING:
        return "oscillates between {} and {} steps/px".format(*numbers), "oscillates"
    return {
        REST: ("rest", "rest"),
        UP: ("speeding up", "up"),
        DOWN: ("slowing down", "down"),
        TAKE_UP: ("backlash", "B"),
    }[kind]


_PHASE_COLOURS = {
    REST: "#eef1f4",
    UP: "#cfe5ea",
    CONSTANT: "#9cc6d1",
    DOWN: "#cfe5ea",
    SWING: "#e9b9ac",
    TAKE_UP: "#dd8a72",
}
_PALE = "#f7e9e6"  # BOARD at the 12 % of the shading
_DENSE_PHASES = 240  # phases from which lines between them would run together


def _marks(panels: tuple[Axes, ...], line: Line, image_pixel: int | None) -> list[Artist]:
    """Shade oscillations and the backlash take-up, mark the image; return the legend's entries."""
    handles: list[Artist] = []
    if line.shifted_pixels:
        end = line.shifted_pixels
        begin = end - line.backlash / line.line_speed
        _shade(panels, [(begin, end - begin)], 0.30)
        text = f"{line.backlash} steps of backlash taken up, px {begin:.6g} to {end}"
        handles.append(Patch(color=BOARD, alpha=0.30, lw=0, label=text))
    if image_pixel is not None:
        at = image_pixel - 1
        for axes in panels:
            axes.axvline(at, color=INK, lw=1, ls=(0, (1, 2)), gid="image")
        text = f"image starts with pixel {image_pixel}"
        handles.append(Line2D([], [], color=INK, lw=1, ls=(0, (1, 2)), label=text))
    return handles + _oscillation_marks(panels, line)


def _lane(axes: Axes, line: Line) -> None:
    """Draw the strip that names the parts of the line, where a name fits."""
    axes.set_label("phases")
    axes.set_axis_off()
    axes.set_ylim(0, 1)
    found = phases(line)
    for kind, colour in _PHASE_COLOURS.items():
        spans = [(phase.begin, phase.end - phase.begin) for phase in found if phase.kind == kind]
        axes.broken_barh(spans, (0, 1), color=colour, lw=0)
    if len(found) <= _DENSE_PHASES:
        axes.vlines([phase.begin for phase in found], 0, 1, color="white", lw=1.5)
    for phase in found:
        characters = 118 * (phase.end - phase.begin) / line.pixels
        texts = [text for text in (phase.text, phase.short) if len(text) + 1 <= characters]
        if texts:
            axes.text((phase.begin + phase.end) / 2, 0.46, texts[0], ha="center", va="center",
                      fontsize=8.5, color=INK)  # fmt: skip


def _oscillation_marks(panels: tuple[Axes, ...], line: Line) -> list[Patch]:
    """Shade every oscillating run; name the first five."""
    runs = list(line_check.oscillations(line)) if line.smooth else []
    _shade(panels, [(run.pixel - 1, run.length) for run in runs], 0.12)
    texts = [
        f"pixels {run.pixel} to {run.pixel + run.length - 1} oscillate: {run.count} entered at "
        f"{run.entry_speed}, the speed swings {run.swing[0]} to {run.swing[1]}"
        for run in runs[:5]
    ]
    if len(runs) > 5:
        texts.append(f"and {len(runs) - 5} more oscillating runs")
    return [Patch(facecolor=_PALE, edgecolor=BOARD, lw=0.6, label=text) for text in texts]


def _shade(panels: tuple[Axes, ...], spans: list[tuple[float, float]], alpha: float) -> None:
    """Shade (begin, length) spans over the whole height of the panels."""
    for axes in panels:
        axes.broken_barh(spans, (0, 1), transform=axes.get_xaxis_transform(), color=BOARD,
                         alpha=alpha, lw=0, zorder=0)  # fmt: skip


SUFFIXES = (".png", ".svg", ".pdf")
_DENSE = 240  # pixels from which single marks would run together
_PER_SECOND = {1: "/s", 2: "/s²", 3: "/s³"}
_FAR = 3  # a limit so many times the peak is said, not drawn: the curve would be flat beside it


def save(drawing: LineDrawing, path: Path) -> None:
    """Write the figure in the format of the suffix. Raises UserError for an unknown suffix."""
    if path.suffix.lower() not in SUFFIXES and not atomic.is_stream(path):
        raise UserError(f"{path}: a drawing ends with {', '.join(SUFFIXES)}")
    below = {"axes.axisbelow": True}
    with progress.shown("drawing") as progressed, plotting.styled(**below):
        figure = build(drawing)
        progressed(0.5)
        plotting.write(figure, path)


def build(drawing: LineDrawing) -> Figure:
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
    meanings = _marks(panels, drawing.line, drawing.image_pixel)
    _lane(lane, drawing.line)
    plotting.time_axis(position, drawing.pixel_hz)
    edge = 0.006 * drawing.line.pixels  # so that marks at both ends are whole
    position.set_xlim(-edge, drawing.line.pixels + edge)
    position.xaxis.set_major_locator(MaxNLocator(integer=True, steps=[1, 2, 5, 10]))
    figure.align_ylabels(panels)
    _captions(figure, drawing, meanings)
    return plotting.write_numbers(figure)


def _captions(figure: Figure, drawing: LineDrawing, meanings: list[Artist]) -> None:
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


def _speed(axes: Axes, motion: kinematics.LineKinematics) -> None:
    _panel(axes, "speed", units.unit(units.SPEED))
    times, speeds = motion.corners
    axes.fill_between(times, speeds, color=MADE, alpha=0.10, lw=0)
    axes.plot(times, speeds, color=MADE, lw=1.8, gid="speed")
    if motion.line.smooth and motion.line.pixels <= _DENSE:
        axes.plot(motion.edges_px, np.append(motion.begin_speeds, motion.end_speeds[-1]), ".",
                  color=MADE, ms=5, clip_on=False, gid="boundary speeds")  # fmt: skip
    if np.min(speeds, initial=0) >= 0:
        axes.set_ylim(0, 1.1 * max(1, np.max(speeds)))


def _acceleration(axes: Axes, motion: kinematics.LineKinematics, limit: int | None) -> None:
    _panel(axes, "acceleration", "steps/px²")
    if motion.line.smooth:
        axes.stairs(motion.accelerations, motion.edges_px, fill=True, color=WARM, alpha=0.15)
        axes.stairs(motion.accelerations, motion.edges_px, color=WARM, lw=1.8, baseline=None,
                    gid="acceleration")  # fmt: skip
        axes.axhline(0, color=FAINT, lw=0.8)
    else:
        _stems(axes, motion.edges_px, motion.speed_changes, WARM, limit)


def _jerk(axes: Axes, motion: kinematics.LineKinematics, limit: int | None) -> None:
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


def _position(axes: Axes, motion: kinematics.LineKinematics) -> None:
    _panel(axes, "position", "steps")
    times, steps = motion.curve()
    axes.plot(times, steps, color=MADE, lw=1.8, gid="position")
    if motion.line.pixels <= _DENSE:
        axes.plot(motion.edges_px, motion.positions, ".", color=MADE, ms=5)


def _limit(axes: Axes, drawing: LineDrawing, order: int) -> None:
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


def _is_far(drawing: LineDrawing, order: int) -> bool:
    figures = drawing.figures
    peaks = {
        units.SPEED: figures.peak_speed,
        units.ACCELERATION: figures.peak_acceleration,
        units.JERK: figures.peak_jerk,
    }
    return drawing.limits[order] > _FAR * peaks[order] > 0


def _second_scale(axes: Axes, drawing: LineDrawing, order: int) -> None:
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
