# SPDX-License-Identifier: MIT
"""How a line kept to the pixel clock: on the board's own time beside locked to the clock."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pixstep import plotting
from pixstep.plotting import BAND, BOARD, FAINT, IDEAL, MADE
from pixstep.simulation.clockjudge import EDGE_TICKS, Kept
from pixstep.simulation.simrun import Job

_LEAST_US = 0.06  # beside a drawing's values at least: the ticks of the timer stay visible
_ROOM, _BESIDE = 0.08, 0.01  # beside them, as a part of the height and of the width
_FOR_LEGEND = 1.6  # bands of free height, for the legend above them
_MOST_MARKED = 400  # pixels; dots of more run together


def build(kept: Kept, job: Job, title: str) -> Figure:
    """Return the figure; of a line that is not locked it has one part."""
    figure = plotting.figure((11, 5.2))
    clock = ", ".join([f"pixel clock {job.pixel_ppm:+g} ppm", *job.flaws.texts()])
    plotting.heading(figure, "Pixel edges against the clock's true edges", f"{title}; {clock}")
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
    low, high = min(0.0, float(np.min(errors_us))), max(0.0, float(np.max(errors_us)))
    rms = float(np.sqrt(np.mean(errors_us**2)))
    axes.axhline(0, color=FAINT, lw=0.8)
    marker = "." if len(kept.pixels) <= _MOST_MARKED else ""
    axes.plot(kept.pixels, errors_us, marker=marker, ms=4, lw=0.8, color=colour)
    room = max(_ROOM * (high - low), _LEAST_US)
    axes.set_ylim(low - room, high + room)
    axes.set_xlim(0, kept.pixels[-1] * (1 + _BESIDE))
    axes.set_ylabel("later than the clock's edge, us")
    axes.set_title(f"{what}: at most {max(-low, high):.3g} us, rms {rms:.3g} us")


def _band(axes: Axes, job: Job, tick_us: float) -> None:
    """Show what an even clock allows, in ticks; of another one the deviation of its jitter."""
    if job.flaws.even:
        width_us, name = EDGE_TICKS * tick_us, f"within {EDGE_TICKS} ticks, as required"
    else:
        width_us, name = job.flaws.jitter_us, "the clock's own jitter, rms"
    if not width_us:
        return
    axes.axhspan(-width_us, width_us, color=BAND, zorder=0, label=name)
    for bound in (-width_us, width_us):
        axes.axhline(bound, color=BOARD, lw=0.8, ls=(0, (4, 3)))
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -1.2 * width_us), max(high, _FOR_LEGEND * width_us, 1.2 * high))
    axes.legend(loc="upper left")
