# SPDX-License-Identifier: MIT
"""How a line kept to the pixel clock: on the board's own time beside locked to the clock."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pixstep import plotting
from pixstep.plotting import BAND, BOARD, FAINT, INK, MADE, WARM, figures, number
from pixstep.simulation.clockjudge import EDGE_TICKS, Kept
from pixstep.simulation.simrun import Job

_LEAST_S = 60e-9  # beside a drawing's values at least: the ticks of the timer stay visible
_ROOM, _BESIDE = 0.08, 0.01  # beside them, as a part of the height and of the width
_FOR_LEGEND = 1.6  # bands of free height, for the legend above them
_MOST_MARKED = 400  # pixels; dots of more run together


def build(kept: Kept, job: Job, title: str) -> Figure:
    """Return the figure; of a line that is not locked it has one part."""
    figure = plotting.figure((11, 5.2))
    sign = "+" if job.pixel_ppm > 0 else ""
    parts = [f"pixel clock {sign}{number(job.pixel_ppm)} ppm", *job.flaws.texts()]
    clock = ", ".join(parts).replace(" us", " µs")
    plotting.heading(figure, "Pixel edges against the clock's true edges", f"{title}; {clock}")
    axes = list(figure.subplots(1, 2 if job.locked else 1, squeeze=False)[0])
    tick_s = 1 / job.tick_hz
    if job.locked:
        _draw(axes[0], kept, kept.free_ticks * tick_s, "Not locked (computed)", WARM)
        unit_s = _draw(axes[1], kept, kept.errors_ticks * tick_s, "Locked (measured)", MADE)
        _band(axes[1], job, tick_s, unit_s)
    else:
        _draw(axes[0], kept, kept.errors_ticks * tick_s, "Not locked (measured)", MADE)
    for each in axes:
        plotting.time_axis(each, job.line_hz)
    return plotting.write_numbers(figure)


def _draw(axes: Axes, kept: Kept, errors_s: np.ndarray, what: str, colour: str) -> float:
    """Draw the errors in ns, µs, ms or s; return the unit, in seconds."""
    unit_s, name = plotting.prefix(float(np.max(np.abs(errors_s), initial=0)))
    errors = errors_s / unit_s
    low, high = min(0.0, float(np.min(errors))), max(0.0, float(np.max(errors)))
    rms = float(np.sqrt(np.mean(errors**2)))
    axes.axhline(0, color=FAINT, lw=0.8)
    marker = "." if len(kept.pixels) <= _MOST_MARKED else ""
    axes.plot(kept.pixels, errors, marker=marker, ms=4, lw=0.8, color=colour)
    room = max(_ROOM * (high - low), _LEAST_S / unit_s)
    axes.set_ylim(low - room, high + room)
    axes.set_xlim(0, kept.pixels[-1] * (1 + _BESIDE))
    axes.set_ylabel(f"later than the clock's edge, {name}s")
    axes.set_title(
        f"{what}\nat most {figures(max(-low, high))} {name}s, rms {figures(rms)} {name}s"
    )
    return unit_s


def _band(axes: Axes, job: Job, tick_s: float, unit_s: float) -> None:
    """Show what an even clock allows, in ticks; of another one the deviation of its jitter."""
    if job.flaws.even:
        width, name = EDGE_TICKS * tick_s / unit_s, f"within {EDGE_TICKS} ticks, as required"
    else:
        width, name = job.flaws.jitter_us * 1e-6 / unit_s, "the clock's own jitter, rms"
    if not width:
        return
    axes.axhspan(-width, width, color=BAND, zorder=0, label=name)
    for bound in (-width, width):
        axes.axhline(bound, color=BOARD, lw=0.8, ls=(0, (4, 3)))
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -1.2 * width), max(high, _FOR_LEGEND * width, 1.2 * high))
    axes.legend(loc="upper left", labelcolor=INK)
