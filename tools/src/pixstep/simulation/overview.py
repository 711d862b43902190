# SPDX-License-Identifier: MIT
"""One figure of all axes of a run: a row an axis, its speed over the ideal and its edge errors."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pixstep import plotting
from pixstep.plotting import BAND, BOARD, IDEAL, MADE
from pixstep.simulation.plots import Trace, ideal_speed, made_speed

_MANY_STEPS = 500  # beyond these dots are drawn small


def build(traces: Sequence[Trace]) -> Figure:
    """Return the figure; its first column is the motion, the second the edge errors."""
    figure = plotting.figure((11, 1.6 + 2.1 * len(traces)))
    rows = figure.subplots(len(traces), 2, sharex=True, squeeze=False, width_ratios=[2, 1])
    for (speed, error), trace in zip(rows, traces, strict=True):
        _speed(speed, trace)
        _errors(error, trace)
    for axes in rows[-1]:
        plotting.time_axis(axes, traces[0].hz)
    longest = max(trace.line.pixels for trace in traces)
    rows[0][0].set_xlim(-0.3, longest + 0.3)
    figure.align_ylabels()
    figure.suptitle("All axes: speed over the ideal, edge errors", x=0.012, ha="left",
                    fontsize=14, weight="bold", color=plotting.INK)  # fmt: skip
    return plotting.write_numbers(figure)


def _speed(axes: Axes, trace: Trace) -> None:
    times, speeds = ideal_speed(trace)
    axes.plot(times, speeds, color=IDEAL, lw=5, alpha=0.55)
    size = 2.5 if len(trace.made_px) > _MANY_STEPS else 5
    axes.plot(*made_speed(trace), ".", ms=size, mew=0, color=MADE, rasterized=True)
    low, high = min(0.0, float(speeds.min())), max(0.0, float(speeds.max()))
    room = 0.08 * (high - low) or 1.0
    axes.set_ylim(low - room, high + room)  # so that a constant speed shows as one
    axes.set_ylabel("steps/s")
    plotting.lengths(axes, trace.scale, "/s")
    axes.set_title(trace.title.partition(", backlash")[0], fontsize=9)


def _errors(axes: Axes, trace: Trace) -> None:
    count = min(len(trace.made_px), len(trace.ideal_px))
    made = trace.made_px[:count]
    errors = (made - trace.ideal_px[:count]) * float(trace.period)
    axes.axhspan(-1, 1, color=BAND, zorder=0)
    for bound in (-1, 1):
        axes.axhline(bound, color=BOARD, lw=0.8, ls=(0, (4, 3)))
    size = 2 if count > _MANY_STEPS else 4
    axes.plot(made, errors, ".", ms=size, mew=0, color=MADE, alpha=0.6, rasterized=True)
    worst = float(np.max(np.abs(errors), initial=0))
    axes.set_ylim(-max(1.25, 1.1 * worst), max(1.25, 1.1 * worst))
    axes.set_ylabel("ticks")
    axes.set_title(f"edge error, one tick is {1e9 / trace.tick_hz:g} ns", fontsize=9)
