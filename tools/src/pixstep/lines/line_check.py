# SPDX-License-Identifier: MIT
"""Check a line on the host as the board will, before anything is uploaded.

The firmware's own check decides what is refused, at which pixel, and why; the names of the findings
are those of firmware/core/base/line_errors.def. Errors refuse the line, warnings do not. This
module adds the figures behind a finding, counts that mend an oscillation, and what only a motor can
want: a limit of the jerk, and of the acceleration of plain lines.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from fractions import Fraction
from itertools import groupby, islice, pairwise, takewhile
from math import inf
from typing import Any, TypedDict, cast

from pixstep import arguments
from pixstep.errors import AskedText, RefusedError
from pixstep.lines import core
from pixstep.lines.core import NO_LIMIT, CoreFinding, CoreLimits
from pixstep.lines.line import Line
from pixstep.lines.runs import safe_entries

ERROR = "error"
WARNING = "warning"
IDLE_PIXEL = "idle_pixel"
MAX_COUNT = 16_383  # steps in a pixel, either direction
WHOLE_STEPS_PX2 = 2  # that whole steps add to the acceleration of the motion that they round
WHOLE_STEPS_PX3 = 4  # and to its jerk


@dataclass(frozen=True)
class Limits:
    """What the machine allows; None switches a rule off.

    Speeds in steps/pixel, accelerations in steps/pixel2, the interval and the period in ticks. Up
    to `start_stop` a plain line may change its count, and its direction, from one pixel to the
    next; without it every change counts as acceleration. A board has two shortest intervals, one
    for plain and one for smooth lines (input registers min_interval_ticks and
    smooth_min_interval_ticks): give the one for the line's decode rule.
    """

    max_speed: int | None = None
    """Highest speed, steps/pixel."""
    max_acceleration: int | None = None
    """Largest change of the speed from pixel to pixel, steps/pixel2."""
    start_stop: int | None = None
    """Speed up to which a plain line may start, stop and turn at once, steps/pixel."""
    jerk_warning: int | None = None
    """Largest change of the acceleration without a warning, steps/pixel3."""
    min_interval_ticks: int | None = None
    """Shortest interval between two steps, ticks."""
    period_ticks: Fraction | None = None
    """Pixel period, ticks, exact; without it no interval is known."""
    reversal_ticks: int | None = None
    """Shortest time from the last step to the first one the other way, ticks."""

    def __post_init__(self) -> None:
        """Raise UserError for what is no limit."""
        for name, value in vars(self).items():
            if value is not None and name != "period_ticks":
                object.__setattr__(self, name, arguments.whole(name, value, high=inf))
        if self.period_ticks is not None:
            exact = arguments.exact("period_ticks", self.period_ticks, 0, inf)
            object.__setattr__(self, "period_ticks", exact)

    def lower(self, other: "Limits") -> "Limits":
        """Return the lower of both limits wherever both have one; times are this one's."""

        least: dict[str, Any] = {}
        for name in ("max_speed", "max_acceleration", "start_stop", "jerk_warning"):
            known = [value for limits in (self, other) if (value := getattr(limits, name))]
            least[name] = min(known, default=None)
        return replace(self, **least)

    def with_rounding(self, line: Line) -> "Limits":
        """Return limits of a motor's motion as limits of the whole steps of a line.

        A plain line's counts are rounded positions. Those of a smooth line are its motion.
        """
        if line.smooth:
            return self
        most, jerk = self.max_acceleration, self.jerk_warning
        return replace(
            self,
            max_acceleration=most + WHOLE_STEPS_PX2 if most else most,
            jerk_warning=None if jerk is None else jerk + WHOLE_STEPS_PX3,
        )

    def of_board(self) -> CoreLimits:
        """Return those that a board has too, as its firmware takes them.

        Without a period no interval is known.
        """
        words = {
            "max_acceleration": self.max_acceleration or 0,
            "start_stop_steps": self.start_stop or 0,
        }
        if self.period_ticks is not None:
            names = ("min_interval_ticks", "smooth_min_interval_ticks", "seek_min_interval_ticks")
            words |= dict.fromkeys(names, self.min_interval_ticks or 0)
            words["reversal_min_ticks"] = self.reversal_ticks or 0
        pixel_ticks = NO_LIMIT if self.period_ticks is None else int(self.period_ticks)
        return CoreLimits(pixel_ticks, **words)


@dataclass(frozen=True)
class Finding:
    """One thing found: a named error or warning at a 1-based pixel.

    What is wrong with the end of a line has the pixel behind the last one, as on the board.
    """

    name: str
    """What it is called, as docs/FAULTS.md lists it: `"oscillates"`."""
    severity: str
    """`"error"`, which refuses the line, or `"warning"`."""
    pixel: int
    """Where it is, from 1."""
    message: str
    """What is wrong, in words."""
    amplitude: int | None = None
    """How far the speed swings around equal counts, steps/pixel; None of other findings."""
    replaces_pixels: int | None = None
    """How many pixels `repair` takes the place of; None if there is no repair."""
    repair: list[int] = field(default_factory=list)
    """Counts that mend it; empty if none are known."""


def check(line: Line, limits: Limits | None = None) -> list[Finding]:
    """Return all findings of a line, in pixel order, errors first at the same pixel."""
    limits = limits or Limits()
    # A smooth line with negative counts has no line speed, by which the firmware judges a backlash
    # before it sees the counts: it is judged without, so that the counts are what is found.
    broken = line.smooth and line.backlash and any(count < 0 for count in line.counts)
    judged = replace(line, backlash=0) if broken else line
    codes = core.check(safe_entries(judged), limits.of_board())
    if line.backlash:
        codes = [code for code in codes if code.name != IDLE_PIXEL]
    found = [item for code in codes for item in _spread(line, _finding(line, code, limits))]
    found += [*_speed_findings(line, limits), *_motor_findings(line, codes, limits)]
    return sorted(found, key=lambda item: (item.pixel, item.severity))


def without_idle_pixel(findings: list[Finding]) -> list[Finding]:
    """Return the findings of counts from a file, which does not tell the backlash."""
    return [item for item in findings if item.name != IDLE_PIXEL]


def refused(findings: list[Finding]) -> bool:
    """True if any finding is an error."""
    return any(item.severity == ERROR for item in findings)


def raise_if_refused(name: str, findings: Sequence[Finding], advice: str = "") -> None:
    """Raise RefusedError naming the first error of a line and its pixel, if there is one."""
    first = next((item for item in findings if item.severity == ERROR), None)
    if first is None:
        return
    where = f"pixel {first.pixel}" if first.pixel else "the line as a whole"
    behind = " ({advice})" if advice else ""
    text = f"line refused: {first.name} at {where}: {first.message}"
    raise RefusedError(AskedText("{name}: {text}" + behind, name=name, text=text, advice=advice))


def exit_status(findings: list[Finding]) -> int:
    """Return 0 for fine, 1 for warnings only, 2 for a refused line."""
    if refused(findings):
        return 2
    return 1 if findings else 0


class FindingFacts(TypedDict):
    """A finding at a pixel, from 1; `repair` are counts that mend an oscillation."""

    name: str
    severity: str
    pixel: int
    message: str
    amplitude: int | None
    replaces_pixels: int | None
    repair: list[int]


def as_json(findings: Iterable[Finding]) -> list[FindingFacts]:
    """Return the findings as plain data."""
    return [cast("FindingFacts", asdict(one)) for one in findings]


def propose_repair(entry_speed: int, count: int, max_acceleration: int | None = None) -> list[int]:
    """Return the counts to put before a run of `count` so that it is entered at that speed.

    One pixel of (v0 + n)/2, or several through evenly spread even speeds while one would need
    more than `max_acceleration`. Empty if no repair exists (the count is odd, so it can never be
    a boundary speed).
    """
    if count % 2 or count <= 0:
        return []
    gap = count - entry_speed
    pieces = 1
    if max_acceleration:
        pieces = max(1, -(-abs(gap) // max(2, max_acceleration // 2 * 2)))
    speeds = [entry_speed + 2 * (gap * i // (2 * pieces)) for i in range(pieces + 1)]
    speeds[-1] = count
    return [(low + high) // 2 for low, high in pairwise(speeds)]


@dataclass(frozen=True)
class Oscillation:
    """`length` pixels of `count` from a 1-based pixel, entered at another speed."""

    pixel: int
    length: int
    count: int
    entry_speed: int

    @property
    def amplitude(self) -> int:
        """How far the boundary speed swings around the count, steps/pixel."""
        return abs(self.entry_speed - self.count)

    @property
    def swing(self) -> tuple[int, int]:
        """The lower and the higher of the two boundary speeds."""
        other = 2 * self.count - self.entry_speed
        return min(other, self.entry_speed), max(other, self.entry_speed)


def oscillations(line: Line) -> Iterator[Oscillation]:
    """Yield every run of two or more equal counts that is entered at another speed."""
    pixel = 1
    for count, group in groupby(line.counts):
        run = Oscillation(pixel, len(list(group)), count, line.speeds[pixel - 1])
        if run.length >= 2 and run.amplitude:
            yield run
        pixel += run.length


def _equal_counts(line: Line, pixel: int) -> int:
    """Return how many equal counts begin at a pixel."""
    count, behind = line.counts[pixel - 1], islice(line.counts, pixel - 1, None)
    return sum(1 for _ in takewhile(lambda other: other == count, behind))


def _spread(line: Line, item: Finding) -> Iterator[Finding]:
    """Yield a finding, of a plain line that is too fast for each of its equal pixels."""
    length = 1
    if item.name == "too_fast" and not line.smooth:
        length = _equal_counts(line, item.pixel)
    for pixel in range(item.pixel, item.pixel + length):
        yield replace(item, pixel=pixel)


def _finding(line: Line, code: CoreFinding, limits: Limits) -> Finding:
    """Return what the firmware's check found, with the figures behind it."""
    severity = ERROR if code.is_error else WARNING
    if code.name in ("oscillates", "ripple"):
        count, speed = line.counts[code.pixel - 1], line.speeds[code.pixel - 1]
        run = Oscillation(code.pixel, _equal_counts(line, code.pixel), count, speed)
        repair = propose_repair(run.entry_speed, run.count, limits.max_acceleration)
        text = f"{code.text}: {_oscillation_text(run, repair)}"
        replaced = 0 if repair else None
        return Finding(code.name, severity, code.pixel, text, run.amplitude, replaced, repair)
    figures = _FIGURES.get(code.name)
    text = f"{code.text}: {figures(line, code.pixel, limits)}" if figures else code.text
    return Finding(code.name, severity, code.pixel, text)


def _oscillation_text(run: Oscillation, repair: list[int]) -> str:
    """Return how equal counts oscillate, and what mends them."""
    count, (low, high) = run.count, run.swing
    text = (
        f"{run.length} pixels of {count} entered at speed {run.entry_speed} swing between {low} "
        f"and {high}"
    )
    if repair:
        return f"{text}; put {', '.join(map(str, repair))} before them"
    return f"{text}; {count} is odd, no boundary speed can equal it: use {count - 1} or {count + 1}"


def _entered(line: Line, pixel: int, _: Limits) -> str:
    count, speed = line.counts[pixel - 1], line.speeds[pixel - 1]
    return f"count {count} entered at speed {speed}, at least {(speed + 1) // 2} is needed"


def _range(line: Line, pixel: int, _: Limits) -> str:
    if line.backlash and line.line_speed > 2 * MAX_COUNT:
        return f"line speed {line.line_speed}, at most {2 * MAX_COUNT}"
    low = 0 if line.smooth else -MAX_COUNT
    return f"count {line.counts[pixel - 1]} is outside {low}..{MAX_COUNT}"


def _acceleration(line: Line, pixel: int, limits: Limits) -> str:
    change = line.speeds[pixel] - line.speeds[pixel - 1]
    return f"acceleration {change} is above {limits.max_acceleration}"


def _rate(line: Line, pixel: int, limits: Limits) -> str:
    speed = _top_speed(line, pixel)
    interval = float((limits.period_ticks or 0) / speed)
    return (
        f"speed {speed} needs a step every {interval:.1f} ticks, the board makes one every "
        f"{limits.min_interval_ticks}"
    )


def _top_speed(line: Line, pixel: int) -> int:
    """Return the highest speed inside a pixel."""
    return max(line.speeds[pixel - 1 : pixel + 1]) if line.smooth else abs(line.counts[pixel - 1])


def _reversal(line: Line, pixel: int, limits: Limits) -> str:
    """Return the time between the last step before a reversal and the first one behind it."""
    after = line.counts[pixel - 1]
    rest = next(i for i, count in enumerate(reversed(line.counts[: pixel - 1])) if count)
    before = line.counts[pixel - 2 - rest]
    between = float((rest + Fraction(1, abs(after))) * (limits.period_ticks or 0))
    return (
        f"from {before} to {after} in {between:.1f} ticks, the board needs {limits.reversal_ticks}"
    )


def _ramp(line: Line, pixel: int, limits: Limits) -> str:
    before, after = line.counts[pixel - 2 : pixel]
    return f"from {before} to {after}, the start/stop speed is {limits.start_stop}"


_FIGURES: dict[str, Callable[[Line, int, Limits], str]] = {
    "reverses_inside_pixel": _entered,
    "zero_while_moving": lambda line, pixel, _: f"entered at speed {line.speeds[pixel - 1]}",
    "negative_count": lambda line, pixel, _: f"count {line.counts[pixel - 1]}",
    "out_of_range": _range,
    "ends_moving": lambda line, *_: f"speed {line.speeds[-1]} at the end",
    "acceleration": _acceleration,
    "too_fast": _rate,
    "reversal_too_fast": _reversal,
    "reversal_without_ramp": _ramp,
    "backlash_no_room": lambda line, *_: f"the first pixel is {line.counts[0]}",
    "backlash_over_speed": lambda line, *_: f"backlash {line.backlash}, speed {line.line_speed}",
}


def _speed_findings(line: Line, limits: Limits) -> Iterator[Finding]:
    """Yield where a line is faster than its motor: the board's rule, at another shortest time."""
    if not limits.max_speed:
        return
    ones = dict.fromkeys(("min_interval_ticks", "smooth_min_interval_ticks"), 1)
    for code in core.check(safe_entries(line), CoreLimits(min(limits.max_speed, NO_LIMIT), **ones)):
        if code.name == "too_fast":
            speed = _top_speed(line, code.pixel)
            text = f"speed {speed} is above {limits.max_speed}"
            yield from _spread(line, Finding(code.name, ERROR, code.pixel, text))


def _motor_findings(line: Line, codes: list[CoreFinding], limits: Limits) -> Iterator[Finding]:
    """Yield what exceeds limits that no board has."""
    if not line.smooth:
        yield from _change_findings(line, limits)
        if limits.jerk_warning is not None:
            yield from _plain_jerk_findings(line, limits)
    elif limits.jerk_warning is not None:
        broken = [code.pixel for code in codes if code.name in _BREAKING]
        yield from _jerk_findings(line, min(broken, default=None), limits.jerk_warning)


# What leaves no speed for the pixels behind it.
_BREAKING = ("negative_count", "out_of_range", "zero_while_moving", "reverses_inside_pixel")


def _jerk_findings(line: Line, broken: int | None, limit: int) -> Iterator[Finding]:
    """Yield a warning where the acceleration changes by more than the limit.

    A line begins at rest, and its end is judged if it comes to rest.
    """
    sound = line.pixels if broken is None else broken - 1
    accelerations = [high - low for low, high in pairwise(line.speeds[: sound + 1])]
    for pixel, (before, after) in enumerate(pairwise((0, *accelerations)), 1):
        if abs(after - before) > limit:
            text = f"the acceleration changes by {abs(after - before)}"
            yield Finding("jerk", WARNING, pixel, text)
    if broken is None and line.speeds[-1] == 0 and accelerations and -accelerations[-1] > limit:
        text = f"the acceleration changes by {-accelerations[-1]} on coming to rest"
        yield Finding("jerk", WARNING, line.pixels, text)


def _plain_jerk_findings(line: Line, limits: Limits) -> Iterator[Finding]:
    """Yield the same of the changes of a plain line's count; those of free speeds are none."""
    slow, limit = limits.start_stop or 0, limits.jerk_warning or 0
    before = 0
    for pixel, (count, following) in enumerate(pairwise((0, *line.counts, 0)), 1):
        free = max(abs(count), abs(following)) <= slow
        change = 0 if free else following - count
        if abs(change - before) > limit:
            text = f"the acceleration changes by {abs(change - before)}"
            yield Finding("jerk", WARNING, min(pixel, line.pixels), text)
        before = change


def _change_findings(line: Line, limits: Limits) -> Iterator[Finding]:
    """Yield every change of a plain line's count that is too much, from rest and to rest included.

    It is noted at the later of the two pixels, a stop at the end at the last.
    """
    slow = limits.start_stop or 0
    for pixel, (before, after) in enumerate(pairwise((0, *line.counts, 0)), 1):
        change = after - before
        too_much = limits.max_acceleration and abs(change) > limits.max_acceleration
        if too_much and max(abs(before), abs(after)) > slow:
            text = f"acceleration {change} is above {limits.max_acceleration}"
            yield Finding("acceleration", ERROR, min(pixel, line.pixels), text)
