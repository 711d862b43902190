# SPDX-License-Identifier: MIT
"""How a line kept to the pixel clock: on the board's own time beside locked to the clock."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pixstep import plotting
from pixstep.plotting import BAND, BOARD, FAINT, IDEAL, MADE
from pixstep.simulation.clockjudge import EDGE_TICKS, Kept
from pixstep.simulation.simrun import Job

_LEAST_US = 0.5  # half the height of a drawing at least: the ticks of the timer stay visible


def build(kept: Kept, job: Job, title: str) -> Figure:
    """Return the figure; of a line that is not locked it has one part."""
    figure = plotting.figure((11, 5.2))
    plotting.heading(figure, "Pixel edges against the clock's true edges", title)
    axes = list(figure.subplots(1, 2 if job.locked else 1, squeeze=False)[0])
    tick_us = 1e6 / job.tick_hz
    if job.locked:
        _draw(axes[0], kept, kept.free_ticks * tick_us, "not locked (computed)", IDEAL)
        _draw(axes[1], kept, kept.errors_ticks * tick_us, "locked (measured)", MADE)
        _band(axes[1], job, tick_us)
    else:
        _draw(axes[0], kept, kept.errors_ticks * tick_us, "not locked (measured)", MADE)
    for each in axes:
        plotting.time_axis(each, job.line_hz)
    return plotting.write_numbers(figure)


def _draw(axes: Axes, kept: Kept, errors_us: np.ndarray, what: str, colour: str) -> None:
    worst = float(np.max(np.abs(errors_us)))
    axes.axhline(0, color=FAINT, lw=0.8)
    axes.plot(kept.pixels, errors_us, ".-", ms=4, lw=0.8, color=colour)
    room = max(1.15 * worst, _LEAST_US)
    axes.set_ylim(-room, room)
    axes.set_xlim(-0.3, kept.pixels[-1] + 0.3)
    axes.set_ylabel("later than the clock's edge, us")
    axes.set_title(f"{what}: at most {worst:.3g} us")


def _band(axes: Axes, job: Job, tick_us: float) -> None:
    """Show what is allowed: ticks of an even clock, else the standard deviation of its jitter."""
    allowed_us = EDGE_TICKS * tick_us if job.flaws.even else job.flaws.jitter_us
    axes.axhspan(-allowed_us, allowed_us, color=BAND, zorder=0)
    for bound in (-allowed_us, allowed_us):
        axes.axhline(bound, color=BOARD, lw=0.8, ls=(0, (4, 3)))
