# SPDX-License-Identifier: MIT
"""Pictures of moves: speed and position, planned and made; and of homing, leg by leg."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.typing import HashableList

from pixstep import plotting
from pixstep.board.state import TRIP_CLOSED, TRIP_OPENED
from pixstep.lines.units import ticks_text
from pixstep.moves.homing import LEGS, Homed, HomingLeg
from pixstep.moves.homing_judge import HYSTERESIS, HomeRun, leg_edges, switch_edges
from pixstep.moves.move_judge import MoveJob, MoveRun
from pixstep.plotting import BAND, BOARD, FAINT, IDEAL, INK, MADE, QUIET, WARM, number

_MOST_DOTS = 60_000
# One colour a leg, in the order of LEGS.
COLOURS = dict(zip(LEGS, ("#6f5f9e", MADE, WARM, "#8a6a2f", BOARD, "#3c784c"), strict=True))
_MARKERS = {TRIP_CLOSED: ("^", "switch closes"), TRIP_OPENED: ("v", "switch opens")}
_FINAL = LEGS[4:]  # what the magnified view shows
_DASHES = (0, (4, 3))


def draw_move(job: MoveJob, path: Path, done: MoveRun | None = None) -> Path:
    """Draw the planned speed and position; of a move that is done every STEP edge over them."""
    with plotting.styled():
        figure = plotting.figure((11, 7.2))
        title = f"Fast move of {number(job.move.steps)} steps"
        plotting.heading(figure, title, _about_move(job, done))
        speed, position = figure.subplots(2, 1, sharex=True)
        counts = np.array(job.move.counts, dtype=np.int64)
        times, places = np.arange(len(counts) + 1), np.concatenate([[0], np.cumsum(counts)])
        rates = counts * float(job.pixel_hz)
        speed.stairs(rates, times, color=IDEAL, lw=4, alpha=0.6, baseline=None)
        position.plot(times, places, color=IDEAL, lw=5, alpha=0.55)
        if done:
            _draw_made(done, speed, position)
        _finish_move_speed(speed, job)
        _finish_move_position(position, job)
        handles = [Line2D([], [], color=IDEAL, lw=4, alpha=0.6, label="plan")]
        if done:
            handles.append(Line2D([], [], color=MADE, lw=1.6, label="STEP edges"))
        where = "upper right" if job.move.steps > 0 else "lower right"  # where no curve is
        speed.legend(handles=handles, loc=where, ncols=2, labelcolor=INK)
        return plotting.write(plotting.write_numbers(figure), path)


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
        dots: dict[str, Any] = {"ms": 1.8 if len(middle) > 2000 else 4, "mew": 0, "color": MADE}
        speed.plot(middle[::every], rates[::every], ".", rasterized=True, **dots)


def _finish_move_speed(axes: Axes, job: MoveJob) -> None:
    axes.set_title("Speed")
    axes.set_ylabel("steps/s")
    sign = 1 if job.move.steps > 0 else -1
    top, reached = (float(steps * job.pixel_hz) * sign for steps in (job.profile.top, job.move.top))
    if abs(top) < 1.6 * abs(reached):
        axes.axhline(top, color=FAINT, lw=0.9, ls=_DASHES, zorder=0)
        text, va = f"profile's top {number(top)} steps/s", "bottom" if top > 0 else "top"
        _note(axes, text, (0, top), (6, 4 * sign), QUIET, ha="left", va=va)
        reached = top
    axes.set_ylim(*sorted((-0.04 * reached, 1.18 * reached)))
    plotting.lengths(axes, job.scale, "/s")


def _finish_move_position(axes: Axes, job: MoveJob) -> None:
    end, steps = job.move.pixels, job.move.steps
    axes.set_title("Position")
    axes.set_ylabel("steps")
    plotting.time_axis(axes, job.pixel_hz)
    axes.plot([end], [steps], "o", ms=6, mfc="white", mec=INK, mew=1.3, zorder=5)
    axes.annotate(
        number(steps), xy=(end, steps), xytext=(0, -12 if steps > 0 else 12),
        textcoords="offset points", ha="right", va="top" if steps > 0 else "bottom", color=INK,
        weight="bold",
    )  # fmt: skip
    axes.set_xlim(-0.01 * end, 1.02 * end)
    axes.margins(y=0.09)
    plotting.lengths(axes, job.scale)


def _about_move(job: MoveJob, done: MoveRun | None) -> str:
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


def draw_homing(run: HomeRun, path: Path, verdict: str) -> Path:
    """Draw where the load was, leg by leg, and how fast; of a homing that made a step at least."""
    with plotting.styled():
        return plotting.write(_homing(run, verdict), path, pil_kwargs={"optimize": True})


def _homing(run: HomeRun, verdict: str) -> Figure:
    rows: list[HashableList[str]] = [["place"], ["speed"]]
    if run.homed:
        rows = [["place", "near"], ["speed", "near"]]
    figure = plotting.figure((12.5, 7.4))
    plan, job = run.job.plan, run.job
    about = (
        f"{job.board} axis {plan.axis} towards {plan.towards} at {float(job.pixel_hz):g} Hz, "
        f"{plan.decode}, slow approach {number(float(plan.slow * job.pixel_hz))} steps/s"
    )
    plotting.heading(figure, "Homing", f"{about}; {run.error or verdict}")
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


def _course(run: HomeRun, leg: HomingLeg, origin_px: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times (pixels) and the motor's places (steps of the plant) at a leg's STEP edges."""
    edges = leg_edges(run.edges, leg, run.job.tick_hz)
    rising, signs = edges.rising, edges.directions()
    first = int(np.searchsorted(run.edges.rising, rising[0])) if len(rising) else 0
    before = run.job.knob("start") + int(run.edges.directions()[:first].sum())
    return rising / float(run.job.period) - origin_px, before + np.cumsum(signs)


def _draw_place(
    axes: Axes, run: HomeRun, leg: HomingLeg, origin_px: float, width: float = 2.2
) -> None:
    times, places = _course(run, leg, origin_px)
    if len(times):
        axes.plot(times, places, color=COLOURS[leg.name], lw=width, solid_capstyle="round")
    if leg.trip and (edges := switch_edges(run, leg, leg.trip)):
        when = edges[0] / float(run.job.period) - origin_px
        made = int(np.searchsorted(times, when + 1 / float(run.job.period))) - 1
        marker, _ = _MARKERS[leg.trip.code]
        axes.plot(
            [when], [places[max(made, 0)]], marker, ms=7, mfc="white", mec=INK, mew=1.3, zorder=6
        )


def _draw_speed(axes: Axes, run: HomeRun, leg: HomingLeg, origin_px: float) -> None:
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
    made = {leg.name for leg in run.legs}
    handles: list[Artist] = [
        Line2D([], [], color=COLOURS[name], lw=2.6, label=name) for name in LEGS if name in made
    ]
    for code in sorted({leg.trip.code for leg in run.legs if leg.trip}):
        shape, label = _MARKERS[code]
        style: dict[str, Any] = {"marker": shape, "ms": 7, "mfc": "white", "mec": INK, "mew": 1.3}
        handles.append(Line2D([], [], ls="", label=label, **style))
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
        axes.axhline(bound, color=FAINT, lw=0.9, ls=_DASHES, zorder=0)
    axes.set_ylim(-1.45 * top, 1.45 * top)
    plotting.lengths(axes, run.job.scale, "/s")
    text = f"HAPs {len(run.job.plan.ramp.counts)}: {number(top)} steps/s, never faster"
    _note(axes, text, (1, top), (-4, 4), QUIET, ha="right", va="bottom")


def _note(
    axes: Axes, text: str, place: tuple[float, float], offset: tuple[float, float], colour: str,
    **align: Any,
) -> None:  # fmt: skip
    """Write beside a line across the axes, at a part of the width."""
    axes.annotate(
        text, xy=place, xycoords=axes.get_yaxis_transform(), xytext=offset,
        textcoords="offset points", color=colour, fontsize=8.5, **align,
    )  # fmt: skip


def _switch(axes: Axes, run: HomeRun) -> None:
    """Shade where the home switch is closed, and where it stays so: its hysteresis."""
    place = run.job.closes_at
    if place is None:
        return
    way = 1 if run.job.closes_above else -1
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
            text = f"{name} limit switch at {number(place)}"
            _note(axes, text, (0, place), (6, -4), BOARD, ha="left", va="top")
    axes.set_ylim(bottom, top)


def _draw_near(axes: Axes, run: HomeRun, homed: Homed) -> None:
    """Draw the legs around the edge that counts, the last one captured, step by step."""
    shown = [leg for leg in run.legs if leg.name in _FINAL and leg.steps]
    last, trip = [(leg, leg.trip) for leg in run.legs if leg.trip][-1]
    origin_px = switch_edges(run, last, trip)[0] / float(run.job.period)
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
        up = shown[-1].steps > 0
        axes.plot(times[-1:], places[-1:], "o", ms=8, mfc="white", mec=INK, mew=1.5, zorder=7)
        axes.annotate(
            f"position {number(homed.position_steps)}", xy=(times[-1], places[-1]),
            xytext=(4, 14 if up else -14), textcoords="offset points", ha="right",
            va="bottom" if up else "top", weight="bold", color=INK,
        )  # fmt: skip
