# SPDX-License-Identifier: MIT
"""The picture of a homing: where the load was, leg by leg, and how fast it moved."""

from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.typing import HashableList

from pixstep import plotting
from pixstep.board.state import TRIP_CLOSED, TRIP_OPENED
from pixstep.moves.homejudge import switch_edges
from pixstep.moves.homesim import HYSTERESIS, HomeRun
from pixstep.moves.homing import LEGS, Homed, Leg
from pixstep.moves.legjudge import leg_edges
from pixstep.plotting import BAND, BOARD, FAINT, INK, MADE, QUIET, WARM, number

# One colour a leg, in the order of LEGS.
COLOURS = dict(zip(LEGS, ("#6f5f9e", MADE, WARM, "#8a6a2f", BOARD, "#3c784c"), strict=True))
_MARKERS = {TRIP_CLOSED: ("^", "switch closes"), TRIP_OPENED: ("v", "switch opens")}
_FINAL = LEGS[4:]  # what the magnified view shows


def draw(run: HomeRun, path: Path, verdict: str) -> Path:
    """Write the picture of a homing that made at least one step."""
    with plotting.styled():
        return plotting.write(_figure(run, verdict), path, pil_kwargs={"optimize": True})


def _figure(run: HomeRun, verdict: str) -> Figure:
    rows: list[HashableList[str]] = [["place"], ["speed"]]
    if run.homed:
        rows = [["place", "near"], ["speed", "near"]]
    figure = plotting.figure((12.5, 7.4))
    plotting.heading(figure, "Homing", _subtitle(run, verdict))
    widths = [1.75, 1] if run.homed else [1]
    panels = figure.subplot_mosaic(rows, width_ratios=widths, height_ratios=[1.6, 1])
    place, speed = panels["place"], panels["speed"]
    speed.sharex(place)
    origin_px = run.legs[0].began_s * float(run.job.pixel_hz)
    for leg in run.legs:
        _draw_place(place, run, leg, origin_px)
        _draw_speed(speed, run, leg, origin_px)
    _finish_place(place, run)
    _finish_speed(speed, run)
    if run.homed:
        _draw_near(panels["near"], run, run.homed)
    return plotting.write_numbers(figure)


def _ticks_px(run: HomeRun) -> float:
    """Return the ticks of a pixel."""
    return float(run.job.tick_hz / run.job.pixel_hz)


def _course(run: HomeRun, leg: Leg, origin_px: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times (pixels) and the motor's places (steps of the plant) at a leg's STEP edges."""
    edges = leg_edges(run.edges, leg, run.job.tick_hz)
    rising, signs = edges.rising, edges.directions()
    first = int(np.searchsorted(run.edges.rising, rising[0])) if len(rising) else 0
    before = run.job.knob("start") + int(run.edges.directions()[:first].sum())
    return rising / _ticks_px(run) - origin_px, before + np.cumsum(signs)


def _draw_place(axes: Axes, run: HomeRun, leg: Leg, origin_px: float, width: float = 2.2) -> None:
    times, places = _course(run, leg, origin_px)
    if len(times):
        axes.plot(times, places, color=COLOURS[leg.name], lw=width, solid_capstyle="round")
    if leg.trip and (edges := switch_edges(run, leg, leg.trip)):
        when = edges[0] / _ticks_px(run) - origin_px
        made = int(np.searchsorted(times, when + 1 / _ticks_px(run))) - 1
        marker, _ = _MARKERS[leg.trip.code]
        axes.plot(
            [when], [places[max(made, 0)]], marker, ms=7, mfc="white", mec=INK, mew=1.3, zorder=6
        )


def _draw_speed(axes: Axes, run: HomeRun, leg: Leg, origin_px: float) -> None:
    times, _ = _course(run, leg, origin_px)
    if len(times) < 2:
        return
    signs = leg_edges(run.edges, leg, run.job.tick_hz).directions()
    rates = signs[1:] / np.diff(times) * float(run.job.pixel_hz)
    middle = (times[1:] + times[:-1]) / 2
    axes.plot(middle, rates, ".", ms=2.6, mew=0, color=COLOURS[leg.name], rasterized=True)


def _finish_place(axes: Axes, run: HomeRun) -> None:
    _switch(axes, run)
    _limits(axes, run)
    axes.set_title("Position of the motor")
    axes.set_ylabel("steps of the plant")
    axes.tick_params(labelbottom=False)
    handles: list[Artist] = [
        Line2D([], [], color=COLOURS[name], lw=2.6, label=name)
        for name in LEGS
        if name in {leg.name for leg in run.legs}
    ]
    trips = {leg.trip.code for leg in run.legs if leg.trip}
    handles += [_marker(*_MARKERS[code]) for code in sorted(trips)]
    if run.job.closes_at is not None:
        text = f"home switch closed: from {number(run.job.closes_at)} on"
        handles.append(Patch(facecolor=BAND, edgecolor=INK, lw=0.6, label=text))
    axes.legend(handles=handles, loc="best", labelcolor=INK, fontsize=9)
    plotting.lengths(axes, run.job.scale)


def _finish_speed(axes: Axes, run: HomeRun) -> None:
    axes.set_title("Speed")
    axes.set_ylabel("steps/s")
    plotting.time_axis(axes, run.job.pixel_hz, "the start")
    top = float(run.job.plan.top * run.job.pixel_hz)
    for bound in (top, -top):
        axes.axhline(bound, color=FAINT, lw=0.9, ls=(0, (4, 3)), zorder=0)
    axes.set_ylim(-1.45 * top, 1.45 * top)
    plotting.lengths(axes, run.job.scale, "/s")
    axes.annotate(
        f"HAPs {len(run.job.plan.ramp.counts)}: {number(top)} steps/s, never faster",
        xy=(1, top),
        xycoords=axes.get_yaxis_transform(),
        xytext=(-4, 4),
        textcoords="offset points",
        ha="right",
        va="bottom",
        color=QUIET,
        fontsize=8.5,
    )


def _switch(axes: Axes, run: HomeRun) -> None:
    """Shade where the home switch is closed, and where it stays so: its hysteresis."""
    place = run.job.closes_at
    if place is None:
        return
    above = run.job.closes_above
    way = 1 if above else -1
    bottom, top = axes.get_ylim()
    room = 0.06 * (top - bottom)
    bottom, top = min(bottom, place - room), max(top, place + room)
    axes.axhspan(place, place + way * 2 * (top - bottom), color=BAND, zorder=0, lw=0)
    opens = place - way * run.job.knob("hyst", HYSTERESIS)
    axes.axhspan(opens, place, color=BAND, alpha=0.5, zorder=0, lw=0)
    axes.axhline(place, color=INK, lw=0.9, zorder=1)
    axes.set_ylim(bottom, top)


def _limits(axes: Axes, run: HomeRun) -> None:
    """Draw the limit switches that are in sight."""
    bottom, top = axes.get_ylim()
    bottom, top = bottom - 0.03 * (top - bottom), top + 0.03 * (top - bottom)
    for place, name in zip(run.job.travel, ("minus", "plus"), strict=False):
        if bottom < place < top:
            axes.axhline(place, color=BOARD, lw=1.1, ls=(0, (5, 3)))
            axes.annotate(
                f"{name} limit switch at {number(place)}",
                xy=(0, place),
                xycoords=axes.get_yaxis_transform(),
                xytext=(6, -4),
                textcoords="offset points",
                color=BOARD,
                fontsize=8.5,
                ha="left",
                va="top",
            )
    axes.set_ylim(bottom, top)


def _counting_edge_px(run: HomeRun) -> float:
    """Return when the last captured edge came: the one that became position 0."""
    leg, trip = [(leg, leg.trip) for leg in run.legs if leg.trip][-1]
    return switch_edges(run, leg, trip)[0] / _ticks_px(run)


def _draw_near(axes: Axes, run: HomeRun, homed: Homed) -> None:
    """Draw the legs around the edge that counts, step by step."""
    shown = [leg for leg in run.legs if leg.name in _FINAL and leg.steps]
    origin_px = _counting_edge_px(run)
    for leg in shown:
        times, places = _course(run, leg, origin_px)
        axes.step(times, places, where="post", color=COLOURS[leg.name], lw=1.8)
        axes.plot(times, places, ".", ms=4, color=COLOURS[leg.name])
        _draw_place(axes, run, leg, origin_px, width=0)
    axes.set_title("The edge that counts, every dot one step")
    plotting.time_axis(axes, run.job.pixel_hz, "that edge")
    axes.margins(y=0.08)
    _switch(axes, run)
    if shown:
        times, places = _course(run, shown[-1], origin_px)
        axes.plot(times[-1:], places[-1:], "o", ms=8, mfc="white", mec=INK, mew=1.5, zorder=7)
        axes.annotate(
            f"position {number(homed.position_steps)}",
            xy=(times[-1], places[-1]),
            xytext=(4, 14 if shown[-1].steps > 0 else -14),
            textcoords="offset points",
            ha="right",
            va="bottom" if shown[-1].steps > 0 else "top",
            weight="bold",
            color=INK,
        )


def _subtitle(run: HomeRun, verdict: str) -> str:
    plan, job = run.job.plan, run.job
    text = (
        f"{job.board} axis {plan.axis} towards {plan.towards} at {float(job.pixel_hz):g} Hz, "
        f"{plan.decode}, slow approach {number(float(plan.slow * job.pixel_hz))} steps/s"
    )
    return f"{text}; {run.error or verdict}"


def _marker(shape: str, label: str) -> Line2D:
    return Line2D([], [], ls="", marker=shape, ms=7, mfc="white", mec=INK, mew=1.3, label=label)
