# SPDX-License-Identifier: MIT
"""The picture of a compensated line: speeds, the offset taken up, the load's predicted error."""

from fractions import Fraction
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from pixstep import plotting
from pixstep.lines import units
from pixstep.plotting import BOARD, FAINT, IDEAL, INK, MADE, QUIET
from pixstep.reversals.compensate import MotorCounts, TakeUpRequest, load_positions


def draw(
    made: MotorCounts,
    request: TakeUpRequest,
    name: str,
    hz: Fraction | None,
    path: Path,
    scale: units.Scale | None = None,
) -> None:
    """Write the picture as PNG to `path`, whole or not at all; `scale` is the motor's."""
    with plotting.styled():
        figure = _figure(made, request, name, hz)
        for axes in figure.axes[1:]:
            plotting.lengths(axes, scale)
        if hz is not None:
            plotting.lengths(figure.axes[0], scale, "/s", float(hz))
        plotting.write(plotting.write_numbers(figure), path)


def _figure(made: MotorCounts, request: TakeUpRequest, name: str, hz: Fraction | None) -> Figure:
    figure = plotting.figure((11, 8.2))
    title = "Reversals: play taken up over the motion"
    plotting.heading(figure, title, _subtitle(made, request, name), 0.954)
    panels = figure.subplots(3, 1, sharex=True, height_ratios=[2.2, 1, 1.4])
    speed, offset, error = panels
    for axes in panels:
        plotting.shade(axes, [(item.pixel, item.last_pixel) for item in made.transitions])
        axes.axhline(0, color=FAINT, lw=0.8, zorder=1)
    _speeds(speed, made)
    _offset(offset, made)
    _error(error, made, request)
    plotting.time_axis(error, hz)
    error.set_xlim(-0.5, len(made.counts) + 0.5)
    return figure


def _subtitle(made: MotorCounts, request: TakeUpRequest, name: str) -> str:
    limits = request.limits
    length = f"{request.transition_px} pixels" if request.transition_px else "fewest pixels"
    return (
        f"{name}: {len(made.counts)} pixels, play {request.play} steps, {length} a transition, "
        f"at most {limits.max_acceleration} steps/px² beyond {limits.start_stop} steps/px"
    )


def _speeds(axes: Axes, made: MotorCounts) -> None:
    edges = np.arange(len(made.counts) + 1)
    axes.stairs(made.ideal, edges, baseline=None, color=IDEAL, lw=5, alpha=0.55, label="ideal")
    axes.stairs(made.counts, edges, baseline=None, color=MADE, lw=1.4, label="motor")
    handles, labels = axes.get_legend_handles_labels()
    patch = Patch(color=BOARD, alpha=0.13, lw=0)
    axes.legend(
        [*handles, patch], [*labels, "transition"],
        loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, labelcolor=INK,
        borderaxespad=0.2,
    )  # fmt: skip
    axes.set_ylabel("steps/px")
    axes.set_title("Speed")


def _offset(axes: Axes, made: MotorCounts) -> None:
    axes.plot(range(len(made.offsets) + 1), (0, *made.offsets), color=MADE, lw=1.4)
    axes.set_ylabel("steps")
    axes.set_title("Offset taken up: motor minus ideal")


def _error(axes: Axes, made: MotorCounts, request: TakeUpRequest) -> None:
    edges = range(len(made.counts) + 1)
    ideal = np.cumsum(made.ideal)
    bare = np.array(load_positions(ideal.tolist(), request.play, made.taken_up)) - ideal
    axes.plot(edges, (0, *bare), color=QUIET, lw=1.1, ls=(0, (4, 3)), label="without compensation")
    axes.plot(edges, (0, *made.load_errors), color=BOARD, lw=1.4, label="compensated")
    axes.set_ylabel("steps")
    axes.set_title(
        f"Load error, predicted: {made.worst_outside} steps away from the transitions, "
        f"{max(map(abs, made.load_errors))} inside"
    )
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, labelcolor=INK,
                borderaxespad=0.2)  # fmt: skip
