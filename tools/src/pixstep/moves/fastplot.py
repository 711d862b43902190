# SPDX-License-Identifier: MIT
"""Pictures of a fast move: speed and position over the pixels, planned and made."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pixstep import plotting
from pixstep.moves.fastsim import MoveJob, MoveRun
from pixstep.plotting import FAINT, IDEAL, INK, MADE, QUIET, number
from pixstep.simulation.report import ticks_text

_MOST_DOTS = 60_000


def draw_plan(job: MoveJob, path: Path) -> Path:
    """Draw the planned speed and position."""
    return _save(path, job, None)


def draw_run(done: MoveRun, path: Path) -> Path:
    """Draw the speed and position of every STEP edge over the plan."""
    return _save(path, done.job, done)


def _save(path: Path, job: MoveJob, done: MoveRun | None) -> Path:
    with plotting.styled():
        return plotting.write(_figure(job, done), path)


def _figure(job: MoveJob, done: MoveRun | None) -> Figure:
    figure = plotting.figure((11, 7.2))
    plotting.heading(figure, _title(job), _subtitle(job, done))
    speed, position = figure.subplots(2, 1, sharex=True)
    times, rates, places = _planned(job)
    speed.stairs(rates, times, color=IDEAL, lw=4, alpha=0.6, baseline=None)
    position.plot(times, places, color=IDEAL, lw=5, alpha=0.55)
    if done:
        _draw_made(done, speed, position)
    _finish_speed(speed, job)
    _finish_position(position, job)
    handles = [Line2D([], [], color=IDEAL, lw=4, alpha=0.6, label="plan")]
    if done:
        handles.append(Line2D([], [], color=MADE, lw=1.6, label="STEP edges"))
    where = "upper right" if job.move.steps > 0 else "lower right"  # where no curve is
    speed.legend(handles=handles, loc=where, ncols=2, labelcolor=INK)
    return plotting.write_numbers(figure)


def _planned(job: MoveJob) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return pixel edges (from 0), signed steps/s in each pixel, steps at its edges."""
    counts = np.array(job.move.counts, dtype=np.int64)
    hz = float(job.pixel_hz)
    return (
        np.arange(len(counts) + 1),
        counts * hz,
        np.concatenate([[0], np.cumsum(counts)]),
    )


def _draw_made(done: MoveRun, speed: Axes, position: Axes) -> None:
    """Draw what the edges say; of many, evenly chosen ones."""
    job = done.job
    edges = done.result.edges.axis(0, job.axis)
    zero = done.judged.summary["line_zero_cycle"]
    if zero is None:
        return
    pixels = (edges.rising - zero) / float(done.result.job.period)
    signs = edges.directions()
    places = np.cumsum(signs)
    every = max(1, len(pixels) // _MOST_DOTS)
    position.plot(np.append(0, pixels[::every]), np.append(0, places[::every]), color=MADE, lw=1.3)
    if len(pixels) > 1:
        rates = signs[1:] / np.diff(pixels) * float(job.pixel_hz)
        middle = (pixels[1:] + pixels[:-1]) / 2
        size = 1.8 if len(middle) > 2000 else 4
        speed.plot(
            middle[::every], rates[::every], ".", ms=size, mew=0, color=MADE, rasterized=True
        )


def _finish_speed(axes: Axes, job: MoveJob) -> None:
    axes.set_title("Speed")
    axes.set_ylabel("steps/s")
    top = float(job.profile.top * job.pixel_hz) * (1 if job.move.steps > 0 else -1)
    reached = float(job.move.top * job.pixel_hz) * (1 if job.move.steps > 0 else -1)
    if abs(top) < 1.6 * abs(reached):
        axes.axhline(top, color=FAINT, lw=0.9, ls=(0, (4, 3)), zorder=0)
        axes.annotate(
            f"profile's top {number(top)} steps/s",
            xy=(0, top),
            xycoords=axes.get_yaxis_transform(),
            xytext=(6, 4 if top > 0 else -4),
            textcoords="offset points",
            color=QUIET,
            fontsize=8.5,
            va="bottom" if top > 0 else "top",
        )
        reached = top
    low, high = sorted((-0.04 * reached, 1.18 * reached))
    axes.set_ylim(low, high)
    plotting.lengths(axes, job.scale, "/s")


def _finish_position(axes: Axes, job: MoveJob) -> None:
    end = job.move.pixels
    axes.set_title("Position")
    axes.set_ylabel("steps")
    plotting.time_axis(axes, job.pixel_hz)
    axes.plot([end], [job.move.steps], "o", ms=6, mfc="white", mec=INK, mew=1.3, zorder=5)
    axes.annotate(
        number(job.move.steps),
        xy=(end, job.move.steps),
        xytext=(0, -12 if job.move.steps > 0 else 12),
        textcoords="offset points",
        ha="right",
        va="top" if job.move.steps > 0 else "bottom",
        color=INK,
        weight="bold",
    )
    axes.set_xlim(-0.01 * end, 1.02 * end)
    axes.margins(y=0.09)
    plotting.lengths(axes, job.scale)


def _title(job: MoveJob) -> str:
    return f"Fast move of {number(job.move.steps)} steps"


def _subtitle(job: MoveJob, done: MoveRun | None) -> str:
    move = job.move
    text = (
        f"{move.pixels} pixels at {float(job.pixel_hz):g} Hz = "
        f"{move.seconds(job.pixel_hz):.3f} s, top {number(move.top)} steps/px"
    )
    if not done:
        return text
    text = f"{job.board} axis {job.axis}, {text}"
    errors = done.judged.axes[0].errors_ticks
    if errors is None:
        return text
    worst = ticks_text(float(np.max(np.abs(errors))))
    return f"{text}; worst edge {worst} ticks from its exact instant"
