# SPDX-License-Identifier: MIT
"""The picture of a run's load: where it was at every pixel edge, and how far off."""

from fractions import Fraction
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from pixstep import plotting
from pixstep.lines import units
from pixstep.plotting import BOARD, FAINT, IDEAL, INK, MADE
from pixstep.simulation.load import AxisLoad


def draw(
    load: AxisLoad, title: str, hz: Fraction, path: Path, scale: units.Scale | None = None
) -> None:
    """Write the picture as PNG to `path`, whole or not at all."""
    with plotting.styled():
        plotting.write(build(load, title, hz, scale), path)


def build(load: AxisLoad, title: str, hz: Fraction, scale: units.Scale | None = None) -> Figure:
    """Return the figure; its axes are position and error."""
    figure = plotting.figure((11, 7.2))
    plotting.heading(figure, "Load at the pixel edges", title)
    position, error = figure.subplots(2, 1, sharex=True, height_ratios=[1.2, 1])
    for axes in (position, error):
        plotting.shade(axes, list(load.spans))
    _positions(position, load)
    _errors(error, load)
    for axes in (position, error):
        plotting.lengths(axes, scale)
    plotting.time_axis(error, hz)
    return plotting.write_numbers(figure)


def _positions(axes: Axes, load: AxisLoad) -> None:
    pixel = np.arange(1, len(load.load_steps) + 1)
    axes.plot(pixel, load.ideal_steps, color=IDEAL, lw=5, alpha=0.55, label="ideal")
    axes.plot(pixel, load.load_steps, ".-", color=MADE, lw=1.0, ms=4, label="load")
    handles, labels = axes.get_legend_handles_labels()
    if load.spans:
        handles.append(Patch(color=BOARD, alpha=0.13, lw=0))
        labels.append("transition")
    axes.legend(handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3,
                labelcolor=INK, borderaxespad=0.2)  # fmt: skip
    axes.set_ylabel("steps")
    axes.set_title("Position")


def _errors(axes: Axes, load: AxisLoad) -> None:
    pixel = np.arange(1, len(load.errors) + 1)
    axes.axhline(0, color=FAINT, lw=0.8)
    axes.plot(pixel, load.errors, color=FAINT, lw=0.8)
    away = load.outside
    axes.plot(pixel[~away], load.errors[~away], "o", ms=4, color=BOARD, mew=0)
    axes.plot(pixel[away], load.errors[away], "o", ms=4, color=MADE, mew=0)
    top = max(1.5, 1.15 * float(np.max(np.abs(load.errors), initial=0)))
    axes.set_ylim(-top, top)
    axes.set_xlim(-0.5, len(load.errors) + 1.5)
    axes.set_ylabel("steps")
    axes.set_title(_error_title(load))


def _error_title(load: AxisLoad) -> str:
    found = load.summary()
    worst = abs(found["max_load_error_steps"])
    if not load.spans:
        return f"Load minus ideal: largest {worst} steps"
    outside = abs(found["max_load_error_outside_steps"])
    return f"Load minus ideal: largest {outside} steps away from the transitions, {worst} inside"
