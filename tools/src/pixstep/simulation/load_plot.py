# SPDX-License-Identifier: MIT
"""The picture of a run's load: where it was at every pixel edge, and how far off."""

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pixstep import atomic
from pixstep.reversals.picture import shade
from pixstep.simulation.load import AxisLoad
from pixstep.simulation.plots import BOARD, FAINT, IDEAL, INK, MADE, STYLE


def draw(load: AxisLoad, title: str, path: Path) -> None:
    """Write the picture as PNG to `path`, whole or not at all."""
    with mpl.rc_context(STYLE):
        figure = _figure(load, title)
        atomic.write_with(path, figure.savefig)
        plt.close(figure)


def _figure(load: AxisLoad, title: str) -> Figure:
    figure, (position, error) = plt.subplots(
        2, 1, figsize=(11, 7.2), layout="constrained", sharex=True,
        gridspec_kw={"height_ratios": [1.2, 1]},
    )  # fmt: skip
    figure.suptitle("Load at the pixel edges\n", x=0.012, ha="left", fontsize=14,
                    weight="bold", color=INK)  # fmt: skip
    figure.text(0.012, 0.948, title, fontsize=9.5, color=FAINT, va="top")
    for axes in (position, error):
        shade(axes, list(load.spans))
    _positions(position, load)
    _errors(error, load)
    return figure


def _positions(axes: Axes, load: AxisLoad) -> None:
    pixel = np.arange(1, len(load.load_steps) + 1)
    axes.plot(pixel, load.ideal_steps, color=IDEAL, lw=5, alpha=0.55, label="ideal")
    axes.plot(pixel, load.load_steps, ".-", color=MADE, lw=1.0, ms=4, label="load")
    handles, labels = axes.get_legend_handles_labels()
    if load.spans:
        handles.append(mpl.patches.Patch(color=BOARD, alpha=0.13, lw=0))
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
    axes.set_xlabel("pixel edge")
    axes.set_title(_error_title(load))


def _error_title(load: AxisLoad) -> str:
    found = load.summary()
    worst = abs(found["max_load_error_steps"])
    if not load.spans:
        return f"Load minus ideal: largest {worst} steps"
    outside = abs(found["max_load_error_outside_steps"])
    return f"Load minus ideal: largest {outside} steps away from the transitions, {worst} inside"
