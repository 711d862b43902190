# SPDX-License-Identifier: MIT
"""The ramp as a picture: every edge's error, its distribution, and the peers' on one scale."""

import math
from fractions import Fraction
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.typing import HashableList

from pixstep import plotting
from pixstep.board import boards
from pixstep.plotting import number
from pixstep_dev.bench import compare, ramp
from pixstep_trials import lines

_BOARD = "uno"
_HZ = Fraction(100)  # the line's counts are the ramp itself
_TICK_HZ = boards.load(_BOARD).tick_hz
_TICK_US = 1e6 / _TICK_HZ


def draw(path: Path) -> None:
    """Run the ramp and draw it into `path`."""
    errors, _ = ramp.errors_us(_BOARD, _HZ)
    with plotting.styled():
        plotting.write(_figure(errors), path)


def _figure(errors: np.ndarray) -> Figure:
    figure = plotting.figure((11, 7.6))
    rows: list[HashableList[str]] = [["over", "spread"], ["peers", "peers"]]
    axes = figure.subplot_mosaic(rows, height_ratios=[3, 2], width_ratios=[4, 1])
    peak, acceleration = number(ramp.PEAK), number(lines.RAMP_STEPS_PER_S2)
    title = f"Ramp from 0 to {peak} steps/s at {acceleration} steps/s²"
    figure.suptitle(f"{title}: edge minus √(2k/a)", x=0.012, ha="left", fontsize=14,
                    weight="bold", color=plotting.INK)  # fmt: skip
    _over_time(axes["over"], errors)
    _spread(axes["spread"], errors)
    _peers(axes["peers"], errors - errors.mean())
    return plotting.write_numbers(figure)


def _over_time(axes: Axes, errors: np.ndarray) -> None:
    """Draw the error of every edge, from line zero."""
    when = ramp.ideal_ticks(len(errors), _TICK_HZ) / _TICK_HZ * float(_HZ)
    axes.axhspan(0, _TICK_US, color=plotting.BAND, zorder=0)
    for bound in (0, _TICK_US):
        axes.axhline(bound, color=plotting.BOARD, lw=0.8, ls=(0, (4, 3)))
    axes.plot(when, errors, ".", ms=2.6, mew=0, alpha=0.6, color=plotting.MADE, rasterized=True)
    axes.axhline(errors.mean(), color=plotting.IDEAL, lw=1.6)
    axes.text(when[-1] * 1.01, errors.mean(), "mean", color=plotting.INK, va="bottom", fontsize=9)
    axes.set_xlim(0, when[-1] * 1.06)
    axes.set_ylim(-0.25 * _TICK_US, 1.25 * _TICK_US)
    plotting.time_axis(axes, _HZ)
    axes.set_ylabel("µs")
    axes.set_title(
        f"Error of each of {number(len(errors))} edges; "
        f"dashed: one timer tick ({1e9 / _TICK_HZ:g} ns)"
    )


def _spread(axes: Axes, errors: np.ndarray) -> None:
    """Draw the distribution of the errors, beside their axis."""
    bins = np.linspace(-0.25 * _TICK_US, 1.25 * _TICK_US, 61)
    axes.hist(errors, bins=bins.tolist(), orientation="horizontal", color=plotting.MADE, alpha=0.85)
    axes.set_ylim(-0.25 * _TICK_US, 1.25 * _TICK_US)
    axes.tick_params(labelleft=False)
    axes.set_xlabel("edges")
    axes.set_title("Distribution")


def _peers(axes: Axes, errors: np.ndarray) -> None:
    """Draw max and RMS of ours and the peers' on one logarithmic scale."""
    goal = compare.goal("ramp")
    ours = (float(np.abs(errors).max()), float(np.sqrt(np.mean(errors**2))))
    rows = [("pixstep", ours), *((peer.project, peer.values) for peer in goal.peers)]
    rows = [rows[0], *sorted(rows[1:], key=lambda row: row[1][0])]
    place = np.arange(len(rows))
    for part, (name, offset, fade) in enumerate((("max", -0.19, 1.0), ("RMS", 0.19, 0.5))):
        values = [row[1][part] for row in rows]
        colours = [plotting.MADE] + [plotting.FAINT] * (len(rows) - 1)
        axes.barh(place + offset, values, height=0.36, left=1e-3, color=colours, alpha=fade)
        for where, value in zip(place + offset, values, strict=True):
            text = f"{name} {_few_digits(value)}"
            axes.text(value * 1.12, where, text, va="center", fontsize=8.5, color=plotting.INK)
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(lambda value, _: _few_digits(value))
    axes.set_xlim(1e-2, 3e4)
    axes.set_yticks(place, [row[0] for row in rows])
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_axisbelow(True)
    axes.set_xlabel("µs, logarithmic; pixstep: after removing the mean")
    axes.set_title("Edge error beside other AVR step generators")


def _few_digits(value: float) -> str:
    """Return a figure with three digits that count, large ones whole."""
    if value >= 100:
        return number(value)
    return number(value, 2 - math.floor(math.log10(value))).rstrip("0").rstrip(".")
