# SPDX-License-Identifier: MIT
"""Plots of a run: motion against the ideal, edge errors, expected against actual positions."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pixstep import plotting
from pixstep.lines import exact, units
from pixstep.lines.line import Line
from pixstep.plotting import BAND, BOARD, FAINT, IDEAL, INK, MADE, WARM, number
from pixstep.simulation.edges import AxisEdges
from pixstep.simulation.pixelgrid import PixelGrid
from pixstep.simulation.report import PixelRow, ticks_text

_MANY_STEPS = 3000  # beyond these dots are drawn small
_ABOVE_INSET = 0.9  # of the highest speed: where the curve is above an inset and its title
_LEAST_INSET, _INSET_LABELS = 0.3, 0.06  # width of an inset and of its ticks, of the whole line


@dataclass(frozen=True)
class Trace:
    """What the plots of one axis need; ticks are counted from line zero."""

    line: Line
    period: Fraction
    tick_hz: int
    zero: int
    edges: AxisEdges
    pixels: list[PixelRow]
    title: str
    scale: units.Scale | None = None  # of the motor, if a machine file gives it
    grid: PixelGrid | None = None  # where the pixels were; else at whole periods from zero

    @property
    def hz(self) -> Fraction:
        """The pixel frequency in Hz."""
        return self.tick_hz / self.period

    @property
    def made_px(self) -> np.ndarray:
        """Times of the rising STEP edges in pixel periods."""
        if self.grid is not None:
            return self.grid.pixels_at(self.edges.rising)
        return (self.edges.rising - self.zero) / float(self.period)

    @property
    def ideal_px(self) -> np.ndarray:
        """Exact instants of all steps of the line in pixel periods."""
        return exact.instants(self.line, self.period) / float(self.period)


def draw(trace: Trace, folder: Path, prefix: str = "") -> list[Path]:
    """Write motion, edge-error and positions as PNG into `folder`; return their paths."""
    paths = []
    for name, make in (
        ("motion", motion),
        ("edge-error", edge_error),
        ("positions", positions),
    ):
        path = folder / f"{prefix}{name}.png"
        with plotting.styled():
            paths.append(plotting.write(make(trace), path))
    return paths


Curve = tuple[np.ndarray, np.ndarray]


def _figure(
    trace: Trace, title: str, *, sharex: bool = False, heights: tuple[int, int] = (1, 1)
) -> tuple[Figure, list[Axes]]:
    """Return a figure of two rows, titled."""
    figure = plotting.figure((11, 7.2))
    plotting.heading(figure, title, trace.title)
    return figure, list(figure.subplots(2, 1, sharex=sharex, height_ratios=heights))


def ideal_speed(trace: Trace) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of the ideal speed: times in pixels, steps per second."""
    hz = trace.tick_hz / float(trace.period)
    times, speeds = [], []
    shift = trace.line.backlash / trace.line.line_speed if trace.line.shifted_pixels else 0.0
    for piece in exact.pieces(trace.line):
        begin = float(piece.begin)
        inserted = trace.line.shifted_pixels == piece.pixel and piece.begin.denominator != 1
        last = inserted and piece.accel == 0 and piece.begin == piece.pixel - Fraction(shift)
        length = shift if last else 1.0
        end_speed = piece.speed + (piece.accel if length == 1.0 else 0)
        times += [begin, begin + length]
        speeds += [piece.direction * piece.speed * hz, piece.direction * end_speed * hz]
    return np.array(times), np.array(speeds)


def made_speed(trace: Trace) -> tuple[np.ndarray, np.ndarray]:
    """Return the speed between neighbouring steps: times in pixels, steps per second."""
    made = trace.made_px
    rate = trace.edges.directions()[1:] / np.diff(made) * trace.tick_hz / float(trace.period)
    keep = np.diff(made) < 1.0  # a rest between two moves is not a speed
    return ((made[1:] + made[:-1]) / 2)[keep], rate[keep]


def motion(trace: Trace) -> Figure:
    """Velocity and position of the edges over the ideal."""
    figure, (speed, position) = _figure(
        trace, "Motion: every STEP edge over the ideal", sharex=True
    )
    made = trace.made_px
    signs = trace.edges.directions()
    times, speeds = ideal_speed(trace)
    speed.plot(times, speeds, color=IDEAL, lw=5, alpha=0.55, label="ideal")
    if len(made) > 1:
        rates = made_speed(trace)
        size = 1.6 if len(made) > _MANY_STEPS else 4.0
        speed.plot(*rates, ".", ms=size, mew=0, color=MADE)
        _magnify(speed, trace, (times, speeds), rates)
    _legend(speed, [_line(IDEAL, 5, "ideal"), _line(MADE, 1.5, "board: 1 / interval")])
    speed.set_ylabel("speed, steps/s")
    speed.set_title("Velocity")
    ideal = trace.ideal_px
    count = np.cumsum(signs)
    wanted = np.cumsum(exact.directions(trace.line))
    position.plot(ideal, wanted, color=IDEAL, lw=5, alpha=0.55)
    position.plot(made, count, color=MADE, lw=1.2)
    position.set_ylabel("position, steps")
    plotting.time_axis(position, trace.hz)
    position.set_title("Position")
    _legend(position, [_line(IDEAL, 5, "ideal"), _line(MADE, 1.5, "board")])
    _take_up_note(speed, trace)
    plotting.lengths(speed, trace.scale, "/s")
    plotting.lengths(position, trace.scale)
    speed.set_xlim(-0.3, trace.line.pixels + 0.3)
    return plotting.write_numbers(figure)


def _magnify(axes: Axes, trace: Trace, ideal: Curve, made: Curve) -> None:
    """Draw the start of a smooth acceleration larger, where single steps can be seen."""
    line = trace.line
    if not line.smooth or line.line_speed == 0:
        return
    flat = next((k for k, v in enumerate(line.speeds) if 5 * v >= line.line_speed), 0)
    high = [k for k, v in enumerate(line.speeds) if v >= _ABOVE_INSET * line.line_speed]
    first, wide = high[0], high[-1] - high[0]
    if flat < 4 or wide < _LEAST_INSET * line.pixels or wide != len(high) - 1:
        return  # no room below the curve
    top, labels = axes.get_ylim()[1], _INSET_LABELS * line.pixels
    place = (first + labels, 0.14 * top, min(0.6 * wide, wide - 1.2 * labels), 0.58 * top)
    inset = axes.inset_axes(place, transform=axes.transData)
    inset.plot(*ideal, color=IDEAL, lw=5, alpha=0.55)
    inset.plot(*made, "o", ms=2.2, mew=0, color=MADE)
    inset.set_xlim(0.5, flat + 0.2)
    inset.set_ylim(0, 1.05 * line.speeds[flat] * trace.tick_hz / float(trace.period))
    inset.set_title("start, every dot one step", fontsize=9, weight="normal")
    inset.tick_params(labelsize=8)


def _take_up_note(axes: Axes, trace: Trace) -> None:
    """Mark where the backlash is taken up."""
    if not trace.line.shifted_pixels:
        return
    end = trace.line.shifted_pixels
    begin = end - trace.line.backlash / trace.line.line_speed
    axes.axvspan(begin, end, color=BOARD, alpha=0.25, lw=0)
    axes.annotate(
        f"{number(trace.line.backlash)} steps of backlash",
        xy=(begin, 0.9 * axes.get_ylim()[1]),
        xytext=(begin - 2.2, 0.9 * axes.get_ylim()[1]),
        arrowprops={"arrowstyle": "-", "color": BOARD},
        color=BOARD,
        va="center",
        ha="right",
    )


def edge_error(trace: Trace) -> Figure:
    """Error of every edge over time, and its distribution."""
    figure, (over, spread) = _figure(trace, "Edge error: edge minus exact instant", heights=(2, 1))
    ideal = trace.ideal_px[: len(trace.made_px)]
    made = trace.made_px[: len(ideal)]
    errors = (made - ideal) * float(trace.period)
    over.axhspan(-1, 1, color=BAND, zorder=0)
    for bound in (-1, 1):
        over.axhline(bound, color=BOARD, lw=0.8, ls=(0, (4, 3)))
    size = 2.0 if len(errors) > _MANY_STEPS else 6.0
    over.plot(made, errors, ".", ms=size, color=MADE, alpha=0.5, mew=0, rasterized=True)
    ends = [done - 1 for _, done in exact.edge_ends(trace.line) if done <= len(errors)]
    over.plot(made[ends], errors[ends], "o", ms=3.5, color=WARM, mec="white", mew=0.3)
    top = max(1.25, 1.1 * float(np.max(np.abs(errors), initial=0)))
    over.set_ylim(-top, top)
    over.set_xlim(-0.3, trace.line.pixels + 0.3)
    over.set_ylabel(f"timer ticks ({1e9 / trace.tick_hz:g} ns)")
    plotting.time_axis(over, trace.hz)
    rms = float(np.sqrt(np.mean(errors**2))) if len(errors) else 0.0
    worst = float(np.max(np.abs(errors), initial=0))
    over.set_title(
        f"worst {ticks_text(worst)} ticks, "
        f"rms {rms:.3f} ticks = {rms / trace.tick_hz * 1e9:.1f} ns "
        f"over {number(len(errors))} steps"
    )
    handles = [
        _dot(MADE, 4, "step"),
        _dot(WARM, 5, "last step of a pixel"),
        _line(BOARD, 1, "one tick"),
    ]
    _legend(over, handles)
    spread.hist(errors, bins=np.linspace(-1.25, 1.25, 101).tolist(), color=MADE, alpha=0.85)
    spread.set_xlabel("error, ticks")
    spread.set_ylabel("steps")
    spread.set_title("Distribution")
    return plotting.write_numbers(figure)


def positions(trace: Trace) -> Figure:
    """The board's expected positions and the counted ones at every pixel edge."""
    figure, (table, difference) = _figure(
        trace, "Positions at the pixel edges", sharex=True,
        heights=(2, 1),
    )  # fmt: skip
    pixel = np.array([row.pixel for row in trace.pixels])
    reference = np.array(exact.expected_positions(trace.line))
    expected = np.array([_number(row.expected_steps) for row in trace.pixels])
    actual = np.array([_number(row.actual_steps) for row in trace.pixels])
    table.plot(pixel, reference, color=IDEAL, lw=5, alpha=0.55)
    table.plot(pixel, expected, "o", ms=6, mfc="none", mec=BOARD, mew=1.1)
    table.plot(pixel, actual, ".", ms=4.5, color=MADE)
    table.set_ylabel("steps")
    table.set_title("Steps made at the end of each pixel")
    plotting.lengths(table, trace.scale)
    handles = [
        _line(IDEAL, 5, "reference"),
        _dot(BOARD, 6, "expected by the board", hollow=True),
        _dot(MADE, 3, "counted STEP edges"),
    ]
    _legend(table, handles)
    difference.axhline(0, color=FAINT, lw=0.8)
    difference.plot(pixel, expected - reference, "o", ms=6, mfc="none", mec=BOARD, mew=1.1)
    difference.plot(pixel, actual - reference, ".", ms=4.5, color=MADE)
    worst = float(np.nanmax(np.abs(np.concatenate([expected, actual]) - np.tile(reference, 2))))
    difference.set_ylim(-max(1.5, 1.2 * worst), max(1.5, 1.2 * worst))
    difference.set_ylabel("steps off the reference")
    plotting.lengths(difference, trace.scale)
    plotting.time_axis(difference, trace.hz)
    same = int(np.sum((expected == reference) & (actual == reference)))
    difference.set_title(f"{same} of {len(pixel)} pixels equal")
    return plotting.write_numbers(figure)


def _number(value: int | None) -> float:
    return float("nan") if value is None else float(value)


def _line(colour: str, width: float, label: str) -> Line2D:
    """Return a legend entry drawn as a line."""
    faint = 0.55 if colour == IDEAL else 1.0
    return Line2D([], [], color=colour, lw=width, alpha=faint, label=label)


def _dot(colour: str, size: float, label: str, *, hollow: bool = False) -> Line2D:
    """Return a legend entry drawn as a dot."""
    fill = "none" if hollow else colour
    return Line2D([], [], ls="", marker="o", ms=size, mfc=fill, mec=colour, label=label)


def _legend(axes: Axes, handles: list[Line2D]) -> None:
    """Draw a legend above the axes on the right, where no curve of any shape can lie below it."""
    axes.legend(
        handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(handles),
        labelcolor=INK, borderaxespad=0.2,
    )  # fmt: skip
