# SPDX-License-Identifier: MIT
"""Plots of a run: motion over the ideal, edge errors, positions, loads, and the clock's edges."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from pixstep import plotting
from pixstep.lines import exact, units
from pixstep.lines.line import Line
from pixstep.plotting import BAND, BOARD, FAINT, IDEAL, INK, MADE, WARM, figures, number
from pixstep.simulation.clock_judge import EDGE_TICKS, ClockKeeping
from pixstep.simulation.job import LineExperiment
from pixstep.simulation.judge import AxisLoad
from pixstep.simulation.logs import AxisEdges
from pixstep.simulation.pixel_clock import PixelGrid
from pixstep.simulation.report import PixelRow

_MANY_STEPS, _MANY_TOGETHER = 3000, 500  # beyond these dots are drawn small
_ABOVE_INSET = 0.9  # of the highest speed: where the curve is above an inset and its title
_LEAST_INSET, _INSET_LABELS = 0.3, 0.06  # width of an inset and of its ticks, of the whole line
_LEAST_S = 60e-9  # beside a clock's values at least: the ticks of the timer stay visible
_ROOM, _BESIDE = 0.08, 0.01  # beside them, as a part of the height and of the width
_FOR_LEGEND = 1.6  # bands of free height, for the legend above them
_MOST_MARKED = 400  # pixels; dots of more run together
_DASHES = (0, (4, 3))

Curve = tuple[np.ndarray, np.ndarray]


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

    def errors(self) -> Curve:
        """Return when the edges of the line's steps came, in pixels, and their errors in ticks."""
        ideal = self.ideal_px[: len(self.made_px)]
        made = self.made_px[: len(ideal)]
        return made, (made - ideal) * float(self.period)

    def ideal_speed(self) -> Curve:
        """Return the corners of the ideal speed: times in pixels, steps per second."""
        line, hz = self.line, self.tick_hz / float(self.period)
        times, speeds = [], []
        shift = line.backlash / line.line_speed if line.shifted_pixels else 0.0
        for piece in exact.pieces(line):
            begin = float(piece.begin)
            inserted = line.shifted_pixels == piece.pixel and piece.begin.denominator != 1
            last = inserted and piece.accel == 0 and piece.begin == piece.pixel - Fraction(shift)
            length = shift if last else 1.0
            end_speed = piece.speed + (piece.accel if length == 1.0 else 0)
            times += [begin, begin + length]
            speeds += [piece.direction * piece.speed * hz, piece.direction * end_speed * hz]
        return np.array(times), np.array(speeds)

    def made_speed(self) -> Curve:
        """Return the speed between neighbouring steps: times in pixels, steps per second."""
        made = self.made_px
        rate = self.edges.directions()[1:] / np.diff(made) * self.tick_hz / float(self.period)
        keep = np.diff(made) < 1.0  # a rest between two moves is not a speed
        return ((made[1:] + made[:-1]) / 2)[keep], rate[keep]


def _two_rows(
    title: str, below: str, *, sharex: bool = False, heights: tuple[float, float] = (1, 1)
) -> tuple[Figure, list[Axes]]:
    """Return a figure of two rows, titled."""
    made = plotting.figure((11, 7.2))
    plotting.heading(made, title, below)
    return made, list(made.subplots(2, 1, sharex=sharex, height_ratios=heights))


def motion(trace: Trace) -> Figure:
    """Velocity and position of the edges over the ideal."""
    made, (speed, position) = _two_rows(
        "Motion: every STEP edge over the ideal", trace.title, sharex=True
    )
    ideal = trace.ideal_speed()
    speed.plot(*ideal, color=IDEAL, lw=5, alpha=0.55, label="ideal")
    steps = len(trace.edges.rising)
    if steps > 1:
        rates = trace.made_speed()
        speed.plot(*rates, ".", ms=1.6 if steps > _MANY_STEPS else 4.0, mew=0, color=MADE)
        _magnify(speed, trace, ideal, rates)
    _legend(speed, [_line(IDEAL, 5, "ideal"), _line(MADE, 1.5, "board: 1 / interval")])
    speed.set_ylabel("speed, steps/s")
    speed.set_title("Velocity")
    wanted = np.cumsum(exact.directions(trace.line))
    position.plot(trace.ideal_px, wanted, color=IDEAL, lw=5, alpha=0.55)
    position.plot(trace.made_px, np.cumsum(trace.edges.directions()), color=MADE, lw=1.2)
    position.set_ylabel("position, steps")
    plotting.time_axis(position, trace.hz)
    position.set_title("Position")
    _legend(position, [_line(IDEAL, 5, "ideal"), _line(MADE, 1.5, "board")])
    _take_up_note(speed, trace)
    plotting.lengths(speed, trace.scale, "/s")
    plotting.lengths(position, trace.scale)
    speed.set_xlim(-0.3, trace.line.pixels + 0.3)
    return plotting.write_numbers(made)


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
    height = 0.9 * axes.get_ylim()[1]
    axes.annotate(
        f"{number(trace.line.backlash)} steps of backlash", xy=(begin, height),
        xytext=(begin - 2.2, height), arrowprops={"arrowstyle": "-", "color": BOARD},
        color=BOARD, va="center", ha="right",
    )  # fmt: skip


def edge_error(trace: Trace) -> Figure:
    """Error of every edge over time, and its distribution."""
    figure, (over, spread) = _two_rows(
        "Edge error: edge minus exact instant", trace.title, heights=(2, 1)
    )
    made, errors = trace.errors()
    _one_tick(over)
    size = 2.0 if len(errors) > _MANY_STEPS else 6.0
    over.plot(made, errors, ".", ms=size, color=MADE, alpha=0.5, mew=0, rasterized=True)
    ends = [done - 1 for _, done in exact.edge_ends(trace.line) if done <= len(errors)]
    over.plot(made[ends], errors[ends], "o", ms=3.5, color=WARM, mec="white", mew=0.3)
    worst = float(np.max(np.abs(errors), initial=0))
    top = max(1.25, 1.1 * worst)
    over.set_ylim(-top, top)
    over.set_xlim(-0.3, trace.line.pixels + 0.3)
    over.set_ylabel(f"timer ticks ({1e9 / trace.tick_hz:g} ns)")
    plotting.time_axis(over, trace.hz)
    rms = float(np.sqrt(np.mean(errors**2))) if len(errors) else 0.0
    over.set_title(
        f"worst {units.ticks_text(worst)} ticks, rms {rms:.3f} ticks = "
        f"{rms / trace.tick_hz * 1e9:.1f} ns over {number(len(errors))} steps"
    )
    last = _dot(WARM, 5, "last step of a pixel")
    _legend(over, [_dot(MADE, 4, "step"), last, _line(BOARD, 1, "one tick")])
    spread.hist(errors, bins=np.linspace(-1.25, 1.25, 101).tolist(), color=MADE, alpha=0.85)
    spread.set_xlabel("error, ticks")
    spread.set_ylabel("steps")
    spread.set_title("Distribution")
    return plotting.write_numbers(figure)


def positions(trace: Trace) -> Figure:
    """The board's expected positions and the counted ones at every pixel edge."""
    figure, (table, difference) = _two_rows(
        "Positions at the pixel edges", trace.title, sharex=True, heights=(2, 1)
    )
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
    handles = [_line(IDEAL, 5, "reference"), _dot(BOARD, 6, "expected by the board", "none")]
    _legend(table, [*handles, _dot(MADE, 3, "counted STEP edges")])
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


OF_TRACE = {"motion": motion, "edge-error": edge_error, "positions": positions}


def together(traces: Sequence[Trace]) -> Figure:
    """Return one figure of all axes, a row an axis: speeds over the ideal, and edge errors."""
    figure = plotting.figure((11, 1.6 + 2.1 * len(traces)))
    rows = figure.subplots(len(traces), 2, sharex=True, squeeze=False, width_ratios=[2, 1])
    for (speed, error), trace in zip(rows, traces, strict=True):
        _speed_of(speed, trace)
        _errors_of(error, trace)
    for axes in rows[-1]:
        plotting.time_axis(axes, traces[0].hz)
    rows[0][0].set_xlim(-0.3, max(trace.line.pixels for trace in traces) + 0.3)
    figure.align_ylabels()
    figure.suptitle("All axes: speed over the ideal, edge errors", x=0.012, ha="left",
                    fontsize=14, weight="bold", color=INK)  # fmt: skip
    return plotting.write_numbers(figure)


def _speed_of(axes: Axes, trace: Trace) -> None:
    times, speeds = trace.ideal_speed()
    axes.plot(times, speeds, color=IDEAL, lw=5, alpha=0.55)
    size = 2.5 if len(trace.edges.rising) > _MANY_TOGETHER else 5
    axes.plot(*trace.made_speed(), ".", ms=size, mew=0, color=MADE, rasterized=True)
    low, high = min(0.0, float(speeds.min())), max(0.0, float(speeds.max()))
    room = 0.08 * (high - low) or 1.0
    axes.set_ylim(low - room, high + room)  # so that a constant speed shows as one
    axes.set_ylabel("steps/s")
    plotting.lengths(axes, trace.scale, "/s")
    axes.set_title(trace.title.partition(", backlash")[0], fontsize=9)


def _errors_of(axes: Axes, trace: Trace) -> None:
    made, errors = trace.errors()
    _one_tick(axes)
    size = 2 if len(made) > _MANY_TOGETHER else 4
    axes.plot(made, errors, ".", ms=size, mew=0, color=MADE, alpha=0.6, rasterized=True)
    top = max(1.25, 1.1 * float(np.max(np.abs(errors), initial=0)))
    axes.set_ylim(-top, top)
    axes.set_ylabel("ticks")
    axes.set_title(f"edge error, one tick is {1e9 / trace.tick_hz:g} ns", fontsize=9)


def load(found: AxisLoad, title: str, hz: Fraction, scale: units.Scale | None = None) -> Figure:
    """Return where the load was at every pixel edge, and how far off."""
    figure, (position, error) = _two_rows(
        "Load at the pixel edges", title, sharex=True, heights=(1.2, 1)
    )
    for axes in (position, error):
        plotting.shade(axes, list(found.spans))
    pixel = np.arange(1, len(found.load_steps) + 1)
    position.plot(pixel, found.ideal_steps, color=IDEAL, lw=5, alpha=0.55, label="ideal")
    position.plot(pixel, found.load_steps, ".-", color=MADE, lw=1.0, ms=4, label="load")
    handles, labels = position.get_legend_handles_labels()
    if found.spans:
        handles.append(Patch(color=BOARD, alpha=0.13, lw=0))
        labels.append("transition")
    position.legend(handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3,
                    labelcolor=INK, borderaxespad=0.2)  # fmt: skip
    position.set_ylabel("steps")
    position.set_title("Position")
    _load_errors(error, found, pixel)
    for axes in (position, error):
        plotting.lengths(axes, scale)
    plotting.time_axis(error, hz)
    return plotting.write_numbers(figure)


def _load_errors(axes: Axes, found: AxisLoad, pixel: np.ndarray) -> None:
    axes.axhline(0, color=FAINT, lw=0.8)
    axes.plot(pixel, found.errors, color=FAINT, lw=0.8)
    for away, colour in ((~found.outside, BOARD), (found.outside, MADE)):
        axes.plot(pixel[away], found.errors[away], "o", ms=4, color=colour, mew=0)
    top = max(1.5, 1.15 * float(np.max(np.abs(found.errors), initial=0)))
    axes.set_ylim(-top, top)
    axes.set_xlim(-0.5, len(found.errors) + 1.5)
    axes.set_ylabel("steps")
    most = found.summary()
    worst, outside = most["max_load_error_steps"], most["max_load_error_outside_steps"]
    text = f"{abs(outside)} steps away from the transitions, {abs(worst)} inside"
    axes.set_title(f"Load minus ideal: largest {text if found.spans else f'{abs(worst)} steps'}")


def clock(kept: ClockKeeping, job: LineExperiment, title: str) -> Figure:
    """Return how a line kept to the clock; of a line that is not locked it has one part."""
    figure = plotting.figure((11, 5.2))
    sign = "+" if job.pixel_ppm > 0 else ""
    parts = [f"pixel clock {sign}{number(job.pixel_ppm)} ppm", *job.flaws.texts()]
    strays = ", ".join(parts).replace(" us", " µs")
    plotting.heading(figure, "Pixel edges against the clock's true edges", f"{title}; {strays}")
    axes = list(figure.subplots(1, 2 if job.locked else 1, squeeze=False)[0])
    tick_s = 1 / job.tick_hz
    if job.locked:
        _late(axes[0], kept, kept.free_ticks * tick_s, "Not locked (computed)", WARM)
        unit_s = _late(axes[1], kept, kept.errors_ticks * tick_s, "Locked (measured)", MADE)
        _allowed(axes[1], job, tick_s, unit_s)
    else:
        _late(axes[0], kept, kept.errors_ticks * tick_s, "Not locked (measured)", MADE)
    for each in axes:
        plotting.time_axis(each, job.line_hz)
    return plotting.write_numbers(figure)


def _late(axes: Axes, kept: ClockKeeping, errors_s: np.ndarray, what: str, colour: str) -> float:
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


def _allowed(axes: Axes, job: LineExperiment, tick_s: float, unit_s: float) -> None:
    """Show what an even clock allows, in ticks; of another one the deviation of its jitter."""
    if job.flaws.even:
        width, name = EDGE_TICKS * tick_s / unit_s, f"within {EDGE_TICKS} ticks, as required"
    else:
        width, name = job.flaws.jitter_us * 1e-6 / unit_s, "the clock's own jitter, rms"
    if not width:
        return
    _band(axes, width, name)
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, -1.2 * width), max(high, _FOR_LEGEND * width, 1.2 * high))
    axes.legend(loc="upper left", labelcolor=INK)


def _one_tick(axes: Axes) -> None:
    _band(axes, 1)


def _band(axes: Axes, width: float, name: str = "") -> None:
    axes.axhspan(-width, width, color=BAND, zorder=0, label=name)
    for bound in (-width, width):
        axes.axhline(bound, color=BOARD, lw=0.8, ls=_DASHES)


def _line(colour: str, width: float, label: str) -> Line2D:
    """Return a legend entry drawn as a line."""
    faint = 0.55 if colour == IDEAL else 1.0
    return Line2D([], [], color=colour, lw=width, alpha=faint, label=label)


def _dot(colour: str, size: float, label: str, fill: str = "") -> Line2D:
    """Return a legend entry drawn as a dot."""
    return Line2D([], [], ls="", marker="o", ms=size, mfc=fill or colour, mec=colour, label=label)


def _legend(axes: Axes, handles: list[Line2D]) -> None:
    """Draw a legend above the axes on the right, where no curve of any shape can lie below it."""
    axes.legend(
        handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=len(handles),
        labelcolor=INK, borderaxespad=0.2,
    )  # fmt: skip
