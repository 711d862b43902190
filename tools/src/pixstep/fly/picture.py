# SPDX-License-Identifier: MIT
"""A fly scan as people look at it: position, speed and deviation of each axis over time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from pixstep import plotting
from pixstep.errors import UserError, one_line
from pixstep.plotting import BAND, BOARD, FAINT, IDEAL, MADE, QUIET

Document = tuple[str, Mapping[str, Any]]
_LEAST_STEPS = 1.5  # of a panel of deviations, so that none is seen as none
_LOOKS: dict[str, dict[str, Any]] = {
    "expected": {"color": IDEAL, "lw": 6, "alpha": 0.55, "solid_capstyle": "round"},
    "actual": {"color": MADE, "lw": 1.4},
}
_MOST_WORDS = 140  # characters of why a run ended early
_CLOSE_POINTS = 3  # of a scan that are drawn large
_LEAST_US = 1.0  # of the panel of the clock
_WIDTH_IN, _ROW_IN = 11.0, 1.85


@dataclass(frozen=True)
class Flown:
    """The events of one flyer, by what its data keys end with."""

    name: str
    columns: Mapping[str, npt.NDArray[Any]]
    units: Mapping[str, str]
    configuration: Mapping[str, float]
    start: Mapping[str, Any]
    stop: Mapping[str, Any]

    @property
    def axes(self) -> list[str]:
        """The names of the axes."""
        ending = "_actual"
        return [key.removesuffix(ending) for key in self.columns if key.endswith(ending)]

    @property
    def time_s(self) -> npt.NDArray[np.float64]:
        """Seconds since line zero, line zero included."""
        return np.concatenate([[0.0], self.columns["time"]])


def plot(documents: Iterable[Document], name: str = "fly") -> Figure:
    """Draw the newest run of a flyer that is in some documents, `(name, document)` each.

    Of each axis: where it was expected, broad and pale, and where it was; its speed; the difference
    of both in steps. Below them the errors of the clock's edges, where the board knows them. The
    points of a scan are on white, run-up and run-down are shaded.
    """
    flown = _flown(list(documents), name)
    with plotting.styled():
        return _build(flown)


def _flown(documents: list[Document], name: str) -> Flown:
    """Return the events of a flyer's newest run."""
    described = [one for kind, one in documents if kind == "descriptor"]
    mine = [one for one in described if f"{name}_pixel" in one["data_keys"]]
    if not mine:
        raise UserError(f"documents: there is none of a flyer {name!r}")
    descriptor = mine[-1]
    pages = [
        one for kind, one in documents
        if kind == "event_page" and one["descriptor"] == descriptor["uid"]
    ]  # fmt: skip
    if not pages:
        raise UserError(f"documents: the newest run of the flyer {name!r} has no pixel")
    run = descriptor["run_start"]
    ends = [one for kind, one in documents if kind == "stop" and one["run_start"] == run]
    starts = [one for kind, one in documents if kind == "start" and one["uid"] == run]
    columns = {
        key.removeprefix(f"{name}_"): np.concatenate([page["data"][key] for page in pages])
        for key in descriptor["data_keys"]
    }
    units = {
        key.removeprefix(f"{name}_"): one["units"] for key, one in descriptor["data_keys"].items()
    }
    configured = descriptor["configuration"].get(name, {}).get("data", {})
    configuration = {key.removeprefix(f"{name}_"): value for key, value in configured.items()}
    last: Mapping[str, Any] = ends[-1] if ends else {}
    first: Mapping[str, Any] = starts[-1] if starts else {}
    return Flown(name, columns, units, configuration, first, last)


def _build(flown: Flown) -> Figure:
    """Return the figure."""
    has_clock = "clock_error" in flown.columns
    below = _below(flown)
    figure = plotting.figure(
        (_WIDTH_IN, 1.0 + 0.2 * below.count("\n") + _ROW_IN * (3 + 0.8 * has_clock))
    )
    title = f"Fly scan of {' and '.join(flown.axes)}" + "\n" * below.count("\n")
    plotting.heading(figure, title, below, 0.955)
    grid = GridSpec(
        3 + has_clock, len(flown.axes), figure=figure,
        height_ratios=[1.7, 0.9, 0.6] + [0.6] * has_clock,
    )  # fmt: skip
    first: Axes | None = None
    for column, axis in enumerate(flown.axes):
        for row, draw in enumerate((_position, _speed, _deviation)):
            axes = figure.add_subplot(grid[row, column], sharex=first)
            first = first or axes
            draw(axes, flown, axis)
            _shade_ramps(axes, flown)
            axes.tick_params(labelbottom=row == 2)
        if not has_clock:
            axes.set_xlabel("seconds after line zero")
    if has_clock:
        axes = figure.add_subplot(grid[3, :], sharex=first)
        _clock(axes, flown)
        _shade_ramps(axes, flown)
        axes.set_xlabel("seconds after line zero")
    return plotting.write_numbers(figure)


def _below(flown: Flown) -> str:
    """Return what was flown, in words."""
    pixels = len(flown.columns["pixel"])
    hz = flown.configuration.get("pixel_hz")
    said = [f"{plotting.number(pixels)} pixels" + (f" at {hz:g} Hz" if hz else "")]
    if "point" in flown.columns:
        said.insert(0, f"{plotting.number(int(flown.columns['point'].max()))} points")
    off = max(int(np.abs(flown.columns[f"{axis}_deviation"]).max()) for axis in flown.axes)
    said.append(
        "every axis where it was expected at every pixel's edge"
        if not off
        else f"up to {off} steps beside the expected position"
    )
    ended = flown.stop.get("exit_status", "success")
    below = ", ".join(said)
    if ended == "success":
        return below
    first, _, _ = (flown.stop.get("reason") or ended).partition(". ")
    reason = one_line(first.removeprefix(f"{flown.name}: complete: "), _MOST_WORDS)
    return f"{below}\nended early: {reason}"


def _position(axes: Axes, flown: Flown, axis: str) -> None:
    time_s = flown.columns["time"]
    for key, look in _LOOKS.items():
        axes.plot(time_s, flown.columns[f"{axis}_{key}"], label=key, **look)
    axes.set_ylabel(flown.units[f"{axis}_actual"])
    axes.set_title(f"{axis}: position")
    places = flown.columns[f"{axis}_expected"]
    axes.legend(loc="upper left" if places[-1] >= places[0] else "lower left")
    if "point" in flown.columns:
        _close_up(axes, flown, axis)


def _close_up(axes: Axes, flown: Flown, axis: str) -> None:
    """Draw the first points of a scan large, in the corner that the line leaves free."""
    point, time_s = flown.columns["point"], flown.columns["time"]
    inside = np.flatnonzero((point > 0) & (point <= _CLOSE_POINTS))
    if not len(inside):  # stopped in the run-up
        return
    shown = slice(max(0, inside[0] - 4), inside[-1] + 2)
    expected, actual = flown.columns[f"{axis}_expected"], flown.columns[f"{axis}_actual"]
    corner = (0.61, 0.1, 0.38, 0.34) if expected[-1] > expected[0] else (0.61, 0.55, 0.38, 0.34)
    inset = axes.inset_axes(corner)
    inset.plot(time_s[shown], expected[shown], "o", ms=7, mfc="none", mec=IDEAL, mew=1.8)
    inset.plot(time_s[shown], actual[shown], ".", ms=5, color=MADE)
    low, high = inset.get_ylim()
    bounds = [int(np.flatnonzero(point == one)[-1]) for one in range(1, int(point[inside[-1]]) + 1)]
    before = time_s[inside[0] - 1] if inside[0] else 0.0
    for number, (left, right) in enumerate(pairwise([before, *time_s[bounds]]), 1):
        inset.axvspan(left, right, color="white" if number % 2 else "#f4f6f8", lw=0, zorder=0)
        place = ((left + right) / 2, high + 0.13 * (high - low))
        inset.text(*place, str(number), ha="center", va="top", fontsize=8, color=QUIET)
    inset.set_ylim(low, high + 0.18 * (high - low))
    inset.axvspan(time_s[shown][0], before, color=BAND, lw=0, zorder=0)
    inset.set_xlim(time_s[shown][0], time_s[shown][-1])
    inset.set_title(f"points 1 to {len(bounds)}, pixel by pixel", fontsize=8.5, weight="normal")
    inset.tick_params(labelsize=7.5)
    inset.grid(visible=False)
    inset.spines[["top", "right"]].set_visible(True)


def _speed(axes: Axes, flown: Flown, axis: str) -> None:
    """Draw the mean speed of each pixel; of pixels that lie beside each other only."""
    unit = flown.units[f"{axis}_actual"]
    pixels, time_s = flown.columns["pixel"], flown.columns["time"]
    for key, look in _LOOKS.items():
        made = np.diff(flown.columns[f"{axis}_{key}"]) / np.diff(time_s)
        made[np.diff(pixels) != 1] = np.nan
        axes.plot((time_s[:-1] + time_s[1:]) / 2, made, **look)
    axes.set_ylabel(f"{unit}/s")
    axes.set_title("speed")


def _deviation(axes: Axes, flown: Flown, axis: str) -> None:
    off, known = flown.columns[f"{axis}_deviation"], flown.columns["records"] > 0
    axes.plot(flown.columns["time"][known], off[known], ".", ms=3, color=BOARD)
    most = max(_LEAST_STEPS, 1.2 * float(np.abs(off).max()))
    axes.set_ylim(-most, most)
    axes.set_ylabel("steps")
    axes.set_title("actual minus expected, at the edges of pixels")


def _clock(axes: Axes, flown: Flown) -> None:
    known = flown.columns["records"] > 0
    time_s, errors = flown.columns["time"][known], flown.columns["clock_error"][known]
    axes.plot(time_s, errors, ".-", ms=3, lw=0.7, color=QUIET)
    axes.axhline(0, color=FAINT, lw=0.6)
    most = max(_LEAST_US, 1.2 * float(np.abs(errors).max(initial=0)))
    axes.set_ylim(-most, most)
    axes.set_ylabel("µs")
    axes.set_title("pixel clock: edge minus planned edge")


def _shade_ramps(axes: Axes, flown: Flown) -> None:
    """Shade what lies before the first point and after the last."""
    time_s = flown.time_s
    axes.set_xlim(0.0, time_s[-1])
    if "point" not in flown.columns:
        return
    inside = np.flatnonzero(flown.columns["point"])
    if len(inside):
        axes.axvspan(0.0, time_s[inside[0]], color=BAND, lw=0, zorder=0)
        axes.axvspan(time_s[inside[-1] + 1], time_s[-1], color=BAND, lw=0, zorder=0)
