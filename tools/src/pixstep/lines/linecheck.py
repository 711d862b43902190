# SPDX-License-Identifier: MIT
"""Check a line on the host by the rules of the controller, before anything is uploaded.

The names of the findings are those of firmware/core/motion/line_errors.def. Errors refuse the
line, warnings do not. The oscillation detector proposes counts that repair what it finds.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from itertools import groupby, pairwise

from pixstep.lines.line import Line

ERROR = "error"
WARNING = "warning"
IDLE_PIXEL = "idle_pixel"
MAX_COUNT = 16_383  # steps in a pixel, either direction


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
    max_acceleration: int | None = None
    start_stop: int | None = None
    jerk_warning: int | None = None
    min_interval_ticks: int | None = None
    period_ticks: Fraction | None = None


@dataclass(frozen=True)
class Finding:
    """One thing found: a named error or warning at a 1-based pixel (0: the line as a whole)."""

    name: str
    severity: str
    pixel: int
    message: str
    amplitude: int | None = None
    replaces_pixels: int | None = None
    repair: list[int] = field(default_factory=list)


def check(line: Line, limits: Limits | None = None) -> list[Finding]:
    """Return all findings of a line, in pixel order, errors first at the same pixel."""
    limits = limits or Limits()
    rules = _smooth_findings if line.smooth else _plain_findings
    found = [*rules(line, limits), *_backlash_findings(line)]
    return sorted(found, key=lambda item: (item.pixel, item.severity))


def without_idle_pixel(findings: list[Finding]) -> list[Finding]:
    """Return the findings of counts from a file, which does not tell the backlash."""
    return [item for item in findings if item.name != IDLE_PIXEL]


def refused(findings: list[Finding]) -> bool:
    """True if any finding is an error."""
    return any(item.severity == ERROR for item in findings)


def exit_status(findings: list[Finding]) -> int:
    """Return 0 for fine, 1 for warnings only, 2 for a refused line."""
    if refused(findings):
        return 2
    return 1 if findings else 0


def as_json(findings: list[Finding]) -> list[dict]:
    """Return the findings as plain data."""
    return [asdict(item) for item in findings]


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


def _smooth_findings(line: Line, limits: Limits) -> Iterator[Finding]:
    """Yield what breaks the decode rule: v' = 2n - v, never negative, 0 at the end."""
    speed = 0
    previous = 0  # a line begins at rest
    if line.counts[:1] == (0,) and line.backlash == 0:
        text = "a leading zero pixel without backlash costs one idle pixel"
        yield Finding(IDLE_PIXEL, WARNING, 1, text)
    for pixel, count in enumerate(line.counts, 1):
        following = 2 * count - speed
        broken = _broken_pixel(pixel, count, speed)
        if broken:
            yield broken
            return
        acceleration = following - speed
        yield from _limit_findings(pixel, acceleration, following, limits)
        yield from _jerk_findings(pixel, acceleration - previous, "", limits)
        speed, previous = following, acceleration
    yield from (_oscillation(run, limits) for run in oscillations(line))
    if speed == 0:
        yield from _jerk_findings(line.pixels, -previous, " on coming to rest", limits)
    else:
        yield Finding("ends_moving", ERROR, line.pixels, f"the line ends at speed {speed}, not 0")


def _jerk_findings(pixel: int, change: int, where: str, limits: Limits) -> Iterator[Finding]:
    """Yield a warning if the acceleration changes by more than the limit."""
    if limits.jerk_warning is not None and abs(change) > limits.jerk_warning:
        text = f"the acceleration changes by {abs(change)}{where}"
        yield Finding("jerk", WARNING, pixel, text)


def _broken_pixel(pixel: int, count: int, speed: int) -> Finding | None:
    """Return the error of a pixel that cannot be decoded at all, if it is one."""
    if count < 0:
        text = f"count {count}: a smooth line has no negative counts"
        return Finding("negative_count", ERROR, pixel, text)
    if count > MAX_COUNT:
        text = f"count {count} is outside 0..{MAX_COUNT}"
        return Finding("out_of_range", ERROR, pixel, text)
    if count == 0 and speed > 0:
        text = f"a zero pixel entered at speed {speed}"
        return Finding("zero_while_moving", ERROR, pixel, text)
    if 2 * count < speed:
        text = f"count {count} entered at speed {speed} would reverse: at least {(speed + 1) // 2}"
        return Finding("reverses_inside_pixel", ERROR, pixel, text)
    return None


def _limit_findings(pixel: int, accel: int, speed: int, limits: Limits) -> Iterator[Finding]:
    """Yield what exceeds the machine's limits in one pixel that ends at `speed`."""
    if limits.max_acceleration and abs(accel) > limits.max_acceleration:
        text = f"acceleration {accel} is above {limits.max_acceleration}"
        yield Finding("acceleration", ERROR, pixel, text)
    if limits.max_speed and speed > limits.max_speed:
        yield Finding("too_fast", ERROR, pixel, f"speed {speed} is above {limits.max_speed}")
    yield from _rate_findings(pixel, speed, limits)


def _rate_findings(pixel: int, speed: int, limits: Limits) -> Iterator[Finding]:
    """Yield an error if `speed` steps a pixel come closer together than the board can."""
    if not (limits.min_interval_ticks and limits.period_ticks and speed):
        return
    interval = limits.period_ticks / speed
    if interval < limits.min_interval_ticks:
        text = (
            f"speed {speed} needs a step every {float(interval):.1f} ticks, "
            f"the board makes one every {limits.min_interval_ticks}"
        )
        yield Finding("too_fast", ERROR, pixel, text)


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


def _oscillation(run: Oscillation, limits: Limits) -> Finding:
    """Describe one oscillating run: error above max(2, 1 % of n), else a warning."""
    count, entry = run.count, run.entry_speed
    serious = run.amplitude > 2 and 100 * run.amplitude > count
    repair = propose_repair(entry, count, limits.max_acceleration)
    text = (
        f"{run.length} pixels of {count} entered at speed {entry}: the boundary speed swings "
        f"between {2 * count - entry} and {entry}"
    )
    if repair:
        text += f"; put {', '.join(map(str, repair))} before them"
    else:
        text += f"; {count} is odd, no boundary speed can equal it: use {count - 1} or {count + 1}"
    name, severity = ("oscillates", ERROR) if serious else ("ripple", WARNING)
    return Finding(name, severity, run.pixel, text, run.amplitude, 0 if repair else None, repair)


def _plain_findings(line: Line, limits: Limits) -> Iterator[Finding]:
    """Yield what breaks a plain line: range and rate of every pixel, changes between pixels."""
    yield from _change_findings(line, limits)
    for pixel, count in enumerate(line.counts, 1):
        if not -MAX_COUNT <= count <= MAX_COUNT:
            text = f"count {count} is outside -{MAX_COUNT}..{MAX_COUNT}"
            yield Finding("out_of_range", ERROR, pixel, text)
            continue
        if limits.max_speed and abs(count) > limits.max_speed:
            text = f"speed {abs(count)} is above {limits.max_speed}"
            yield Finding("too_fast", ERROR, pixel, text)
        yield from _rate_findings(pixel, abs(count), limits)


def _change_findings(line: Line, limits: Limits) -> Iterator[Finding]:
    """Yield every change of a plain line's count that is too much, from rest and to rest included.

    It is noted at the later of the two pixels, a stop at the end at the last.
    """
    slow = limits.start_stop or 0
    for pixel, (before, after) in enumerate(pairwise((0, *line.counts, 0)), 1):
        if max(abs(before), abs(after)) <= slow:
            continue
        at = min(pixel, line.pixels)
        if limits.start_stop is not None and before * after < 0:
            text = f"{before} to {after} without a ramp, the start/stop speed is {slow}"
            yield Finding("reversal_without_ramp", ERROR, at, text)
        change = after - before
        if limits.max_acceleration and abs(change) > limits.max_acceleration:
            text = f"acceleration {change} is above {limits.max_acceleration}"
            yield Finding("acceleration", ERROR, at, text)


def _backlash_findings(line: Line) -> Iterator[Finding]:
    """Yield why the backlash cannot be taken up by shifting the profile, if so."""
    if line.backlash == 0:
        return
    if not line.smooth:
        yield Finding("backlash_plain", ERROR, 0, "only a smooth line takes up backlash")
        return
    if line.counts and line.counts[0] != 0:
        text = f"backlash {line.backlash} needs a leading zero pixel, the first is {line.counts[0]}"
        yield Finding("backlash_no_room", ERROR, 1, text)
    if line.backlash > line.line_speed:
        text = f"backlash {line.backlash} is above the line speed {line.line_speed}"
        yield Finding("backlash_over_speed", ERROR, 0, text)
