# SPDX-License-Identifier: MIT
"""The circle test as people look at it: radius error over angle, exaggerated, all passes."""

from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import FuncFormatter, MaxNLocator

from pixstep import plotting
from pixstep.plotting import BOARD, FAINT, INK, MADE
from pixstep.trajectories.circle import Roundness, TableTrace, Unit
from pixstep.trajectories.runs import ORIGINAL

_PLACES = 3600  # drawn in a revolution: of those beside each other the one that is furthest off
_SHARE = 0.3  # of the circle's radius by which the largest error is drawn


def draw(runs: Sequence[Roundness], unit: Unit, below: str, path: Path) -> None:
    """Write the picture of a circle test to `path`, whole or not at all."""
    with plotting.styled():
        plotting.write(build(runs, unit, below), path)


def draw_errors(
    runs: Sequence[TableTrace], unit: Unit, below: str, path: Path, along: str = "seconds"
) -> None:
    """Write the load errors of a table that is no circle, over time, or as `along` says."""
    with plotting.styled():
        figure = plotting.figure((11, 6.4))
        plotting.heading(figure, "Load minus table", below)
        panels = figure.subplots(2, 1, sharex=True)
        for axis, axes in enumerate(panels):
            for run in runs:
                values = run.load_errors[:, axis] / float(unit.counts)
                axes.plot(run.times_s, values, color=_colour(run.name), lw=1, label=run.name)
            if not any(np.any(run.load_errors[:, axis]) for run in runs):
                axes.set_ylim(-1, 1)
            axes.set_ylabel(unit.name)
            axes.set_title(f"Axis {axis + 1}")
        panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, labelcolor=INK)
        panels[1].set_xlabel(along)
        plotting.write(figure, path)


def build(runs: Sequence[Roundness], unit: Unit, below: str) -> Figure:
    """Return the figure of a circle test."""
    figure = plotting.figure((12.4, 7.0))
    passes = runs[0].circle.revolutions
    drawn = f"{passes} passes over each other, the first broad" if passes > 1 else "1 pass"
    title = "Circle test: radius error over angle"
    plotting.heading(figure, title, f"{below}; {drawn}", 0.945)
    grid = figure.add_gridspec(2, 2, width_ratios=[1, 1.1])
    around = figure.add_subplot(grid[:, 0], axes_class=PolarAxes)
    assert isinstance(around, PolarAxes)
    _polar(around, runs, _sized(unit, runs))
    best = min(runs, key=lambda run: abs(run.worst))
    for place, chosen in ((grid[0, 1], runs), (grid[1, 1], [best])):
        axes = figure.add_subplot(place)
        sized = _sized(unit, chosen)
        _straight(axes, chosen, sized)
        axes.set_title(" and ".join(_title(run, sized) for run in chosen), fontsize=9.5)
    axes.set_xlabel("degrees")
    return figure


def _sized(unit: Unit, runs: Sequence[Roundness]) -> Unit:
    """Return millimetres as nm, µm or mm, as the largest error of some runs needs it."""
    if unit.name != "mm":
        return unit
    size, prefix = plotting.prefix(max(unit.of(abs(run.worst)) for run in runs) / 1000)
    return Unit(f"{prefix}m", unit.counts * Fraction(size * 1000).limit_denominator(10**6))


def _title(run: Roundness, unit: Unit) -> str:
    return f"{run.name}: at most {plotting.figures(unit.of(abs(run.worst)))} {unit.name}"


def _colour(name: str) -> str:
    return BOARD if name == ORIGINAL else MADE


def _passes(run: Roundness) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield angles (radians, 0 to 2 pi) and errors of each pass, as many as are drawn."""
    turn = np.minimum(run.angles // (2 * np.pi), run.circle.revolutions - 1)
    for number in range(run.circle.revolutions):
        mine = turn == number
        angles, errors = run.angles[mine] - 2 * np.pi * number, run.errors[mine]
        bins = np.minimum(angles / (2 * np.pi) * _PLACES, _PLACES - 1).astype(np.int64)
        order = np.lexsort((-np.abs(errors), bins))
        _, first = np.unique(bins[order], return_index=True)
        yield angles[order][first], errors[order][first]


def _looks(run: Roundness) -> Iterator[dict[str, Any]]:
    """Yield the look of each pass: the first broad and pale, the last thin and dark."""
    last = run.circle.revolutions - 1
    for number in range(run.circle.revolutions):
        early = (last - number) / max(last, 1)
        width, strength = 1.0 + 4.0 * early, 0.9 - 0.6 * early
        yield {"color": _colour(run.name), "lw": width, "alpha": strength}


def _polar(axes: PolarAxes, runs: Sequence[Roundness], unit: Unit) -> None:
    """Draw every pass around the circle, its error exaggerated."""
    largest = max(unit.of(abs(run.worst)) for run in runs) or 1.0
    gain = _SHARE / largest
    round_angle = np.linspace(0, 2 * np.pi, 721)
    axes.plot(round_angle, np.ones_like(round_angle), color=FAINT, lw=1.2, ls=(0, (4, 3)))
    for run in runs:
        for (angles, errors), look in zip(_passes(run), _looks(run), strict=True):
            axes.plot(angles, 1 + gain * errors / float(unit.counts), **look)
    _rings(axes, largest)
    names = dict.fromkeys(run.name for run in runs)
    marks = [Line2D([], [], color=_colour(name)) for name in names]
    axes.legend(marks, names, loc="center", labelcolor=INK)
    circle = runs[0].circle
    exaggerated = gain * float(circle.radius / unit.counts)
    axes.set_title(
        f"errors enlarged {exaggerated:.3g} times against the circle; rings: {unit.name}",
        fontsize=9.5, pad=30,
    )  # fmt: skip


def _rings(axes: PolarAxes, largest: float) -> None:
    """Draw a ring for each round error up to the largest one."""
    ticks = np.array(MaxNLocator(4).tick_values(-largest, largest))
    ticks = ticks[np.abs(ticks) <= 1.2 * largest]
    axes.set_rlim(0, 1 + 1.25 * _SHARE)
    axes.set_rgrids(
        1 + _SHARE / largest * ticks, [_signed(tick) for tick in ticks],
        angle=300, fontsize=8, color=INK, ha="center", va="center",
        bbox={"facecolor": "white", "alpha": 0.85, "edgecolor": "none", "pad": 1.0}, zorder=9,
    )  # fmt: skip


def _signed(tick: float) -> str:
    """Return the error that a ring stands for, with its sign."""
    return f"{tick:+g}".replace("-", plotting.MINUS) if tick else ""  # the dashed circle


def _figure(value: float, _place: int) -> str:
    """Return a number without an exponent."""
    text = f"{value:.9f}".rstrip("0").rstrip(".")
    return "0" if text in ("", "-0") else text.replace("-", plotting.MINUS)


def _straight(axes: Axes, runs: Sequence[Roundness], unit: Unit) -> None:
    """Draw the errors over the angle, the passes over each other."""
    axes.axhline(0, color=FAINT, lw=0.8)
    for run in runs:
        for (angles, errors), look in zip(_passes(run), _looks(run), strict=True):
            axes.plot(np.degrees(angles), errors / float(unit.counts), **look)
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 45))
    axes.set_ylabel(unit.name)
    axes.yaxis.set_major_formatter(FuncFormatter(_figure))
