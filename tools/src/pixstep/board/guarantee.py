# SPDX-License-Identifier: MIT
"""What a board is guaranteed to follow: lines that run together, its clock, its bus.

The board's main loop is replayed with the costs that were measured on its image and with higher
ones, at the clock asked and at slower ones: which part of a line comes first depends on every cost
and on the clock, so that no single margin is the worst one, and a line may pass by chance where one
that is a little slower does not. Every part must be there some time before it is needed, since the
replay does not know at which moment of a round an edge or a byte comes. A line that passes runs
without a fault whatever a host asks meanwhile. What a replay cannot know it does not promise: a
clock that is worse than declared, a host that sends line data too late.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise, product

from pixstep.board import boards, costs, settings
from pixstep.board.device import Device
from pixstep.board.port import BAUD
from pixstep.errors import RefusedError
from pixstep.lines import runs
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import ERROR, Finding
from pixstep.lines.replay import Loop, Replay, ReplayVerdict
from pixstep.lines.units import period_ticks, refuse_periods

NAME = "beyond_guarantee"  # of what is found
INTERVALS = 1.1  # of the shortest interval of several axes: at 1.05 some runs end in underruns
LONE = 1.05  # of that of a single axis: beside some thousand edges a second one run of many failed
INSIDE = 1.15  # where edges of the clock come inside of a pixel, in the middle of a pulse train
BURST = 1.3  # and where the train begins behind slower steps: the interrupt has more to do there
MOST_EDGES_HZ = 5000  # with more than this nobody has tried what a board follows
# Times what is measured: a part of the most, and the most, unless the table of costs misses more of
# its worst probe. Chosen by the campaign's sets, by lines at guaranteed rates beside a saturated
# bus, and by what a search found: with less, some that were accepted failed. On a fast clock small
# costs add up that are not reckoned.
_PART, _MOST, _MOST_FAST = 1.08, 1.14, 1.25
_FAST_HZ = 2000  # of the clock's edges
_CLOCKS = (Fraction(1), Fraction(97, 100), Fraction(93, 100))  # shares of the one asked
_SPARE_TICKS = 2500  # by which each part must be early, beside all that is reckoned
ADVICE = "beyond=True lets the board try"
MOTIONS = ("constant", "smooth", "ramp")
DECLARED_PPM = 1000  # a clock may be so much faster
# A master that asks again as soon as it has a reply: bytes of a request and its reply, and how long
# the bus rests between them, measured (silences, rounds of the board).
_BYTES, _REST_S, _BYTE_BITS = 100, 0.0043, 11
_WINDOW_S, _FRAME_BYTES = 0.008, 256  # as long as rings last; all of it may fall into a frame
_DATA_SHARE = 0.2  # of the bytes on the bus are line data, its checks and records the rest
_BEHIND_BYTES = 80  # of line data that come while records are read and a block is on its way
_ROUND_S, _CALLS_STREAMED = 0.004, 2  # firmware/app/round.c
_DATA_BYTE_CYCLES = 300  # of a byte of counts, to check and keep it
_LEAD_TICKS = 0x20000  # firmware/app/reference.c
_MARKS = 16
_FEWER = 64  # parts of a line's counts, or of its clock, by which less is tried
_LOOK_PX = 256  # of a long line, behind the pixel that is late
_SLOWER = 32  # rates that are tried from a half of the highest on
_LEAST_PX, _HELD_S, _RAMP_STEPS_S2 = 48, 2, 100_000  # of a line that shows a rate
_LONG_PX = 6000  # of one whose counts come while it runs
_BUSY = 0.5  # of the time: no look further ahead would help


@dataclass(frozen=True)
class LineConditions:
    """What lines run on: the board, the frequency of pixels, settings of its clock, the bus."""

    board: str
    pixel_hz: Fraction
    sync: int = 1
    divider: int = 1
    baud: int = BAUD
    ppm: float = DECLARED_PPM


def world(
    board: str,
    pixel_hz: Fraction,
    clock: Mapping[str, int] | None = None,
    baud: int = BAUD,
    ppm: float = 0.0,
) -> LineConditions:
    """Return a world whose clock has these settings: `sync` and `divider`.

    `ppm`: the clock is so much faster, if that is more than is declared anyway.
    """
    known = settings.defaults() | dict(clock or {})
    declared = max(ppm, DECLARED_PPM)
    return LineConditions(
        board, pixel_hz, known["sync"], settings.divider_of(known), baud, declared
    )


def of_board(
    board: Device, pixel_hz: Fraction, clock: Mapping[str, int] | None = None
) -> LineConditions | None:
    """Return the world of a connected board; None: nobody has measured what its image costs."""
    name = board.who().board
    known = settings.read(board)
    baud = known["baud_100"] * 100
    return world(name, pixel_hz, known | dict(clock or {}), baud) if name in costs.table() else None


@dataclass(frozen=True)
class LatePlace:
    """The first place where a board may be late, and what it would follow instead."""

    axis: int  # a place in the sequence of lines
    pixel: int
    hz: Fraction | None  # of pixels, with the same counts
    steps: int  # a pixel, of the fastest, at the same clock
    most_steps: int  # that it has


def loop_of(world: LineConditions, margin: float = 1.0) -> Loop:
    """Return the board's main loop in this world."""
    kind = boards.load(world.board)
    nominal = float(period_ticks(world.pixel_hz, kind.tick_hz))
    locked = settings.locks({"sync": world.sync})
    clock = nominal / world.divider
    most = _MARKS * world.divider
    lead, all_ahead = (
        min(int(ticks // clock) + 1, most) for ticks in (_LEAD_TICKS, _LEAD_TICKS + clock * 3 / 8)
    )
    a_second = world.baud / _BYTE_BITS
    return Loop(
        kind.axes,
        kind.all_features,
        nominal / (1 + world.ppm / 1e6) if locked else nominal,
        world.divider,
        lead if locked else 0,
        all_ahead - lead if locked else 0,
        min(_WINDOW_S * a_second, _FRAME_BYTES) / _WINDOW_S / kind.tick_hz,
        _BYTES / (_BYTES / a_second + _REST_S) / kind.tick_hz,
        _ROUND_S * kind.tick_hz,
        _SPARE_TICKS,
        margin,
    )


def _margins(world: LineConditions) -> tuple[float, ...]:
    most = _MOST_FAST if world.pixel_hz * world.divider >= _FAST_HZ else _MOST
    return 1.0, _PART, max(most, 1.0 + costs.of(world.board).low)


def verdicts(lines: Sequence[Line], world: LineConditions) -> Iterator[ReplayVerdict]:
    """Yield how the lines fare with each margin, at the clock asked and at slower ones.

    Of a line that does not fit its queue more comes while the board moves.
    """
    streamed = [line for line in lines if _is_longer(line, _room(world))]
    turning = any(line.turns for line in streamed)
    found = costs.of_replay(world.board, streamed=bool(streamed), turning=turning)
    if streamed:
        found["request_byte"] += _DATA_SHARE * _DATA_BYTE_CYCLES
    replay = Replay(lines)
    most_calls = _CALLS_STREAMED if streamed else 0
    for share, margin in product(_CLOCKS, _margins(world)):
        loop = loop_of(replace(world, pixel_hz=share * world.pixel_hz), margin)
        yield replay.judge(found, replace(loop, most_calls=most_calls))


def first_late(lines: Sequence[Line], world: LineConditions) -> ReplayVerdict | None:
    """Return the first verdict by which a line is late; None: all are followed."""
    for found in (_too_fast_clock(world), _too_close(lines, world), _starved(lines, world)):
        if found:
            return found
    return next((one for one in verdicts(lines, world) if not one.follows), None)


def _too_fast_clock(world: LineConditions) -> ReplayVerdict | None:
    """Return that a clock has more edges a second than the boards were tried with."""
    fast = world.pixel_hz * world.divider > MOST_EDGES_HZ
    return ReplayVerdict(False, 0, 1, 0.0, 0.0, 0.0) if fast else None


def _too_close(lines: Sequence[Line], world: LineConditions) -> ReplayVerdict | None:
    """Return where the step interrupt has less time than it is promised.

    The boards accept shorter intervals, at which now and then its calls meet a byte, an edge of the
    clock and a timer.
    """
    loop, kind = loop_of(world), boards.load(world.board)
    inside = world.divider > 1 or not settings.locks({"sync": world.sync})
    for axis, line in enumerate(lines):
        share = INTERVALS if len(lines) > 1 else LONE
        if inside:
            share = INSIDE if _is_even(line) else BURST
        least = (kind.smooth_min_intervals_ticks if line.smooth else kind.min_intervals_ticks)[
            len(lines) - 1
        ]
        fastest = _fastest(line)
        if fastest and loop.pixel_ticks / fastest < share * least:
            places = line.speeds[1:] if line.smooth else [abs(count) for count in line.counts]
            pixel = next((k for k, one in enumerate(places, 1) if one == fastest), 1)
            return ReplayVerdict(False, axis, pixel, 0.0, 0.0, 1.0)
    return None


def _starved(lines: Sequence[Line], world: LineConditions) -> ReplayVerdict | None:
    """Return the line for which counts cannot come in time, by the bytes that the bus carries.

    Those that do not fit their queues share them.
    """
    room = _room(world)
    longer = [axis for axis, line in enumerate(lines) if _is_longer(line, room)]
    loop = loop_of(world)
    a_pixel = _DATA_SHARE * loop.asked_per_tick * loop.pixel_ticks / max(1, len(longer))
    for axis in longer:
        if pixel := _dry_at(lines[axis], room - _BEHIND_BYTES, a_pixel):
            return ReplayVerdict(False, axis, pixel, 0.0, 0.0, 0.0)
    return None


def _dry_at(line: Line, room: int, bytes_a_pixel: float) -> int:
    """Return the first pixel that a queue of so many bytes lacks, full at first; 0: it lacks none.

    While the line moves, so many bytes come in each pixel, as far as there is room for them.
    """
    lacks, pixel = 0.0, 1
    for size, pixels in runs.packed_entries(runs.queue_entries(line)):
        lacks += size
        if lacks > room:
            return pixel
        lacks = max(0.0, lacks - pixels * bytes_a_pixel)
        pixel += pixels
    return 0


def _room(world: LineConditions) -> int:
    return boards.load(world.board).queue_entries * runs.MOST_BYTES


def _is_longer(line: Line, room: int) -> bool:
    """Whether a line takes more bytes than that; of most its first pixels show it."""
    parts = (_cut(line, room), line)
    return any(runs.packed_size(runs.queue_entries(part)) > room for part in parts)


def follows(lines: Sequence[Line], world: LineConditions) -> bool:
    """Return whether the board is guaranteed to follow the lines."""
    return first_late(lines, world) is None


def judge(lines: Sequence[Line], world: LineConditions) -> LatePlace | None:
    """Return where the board may be late, and what fits; None: it follows the lines."""
    late = first_late(lines, world)
    if late is None:
        return None
    # Counts that come too late are missing in a line that is longer than its queue.
    starved = _starved(lines, world)
    near = lines if starved else [_cut(line, late.pixel + _LOOK_PX) for line in lines]
    most = max(_fastest(line) for line in lines)
    share = highest(_FEWER, lambda part: follows([_slower(one, part) for one in near], world))
    slower = highest(
        _FEWER, lambda part: follows(near, replace(world, pixel_hz=world.pixel_hz * part / _FEWER))
    )
    hz = world.pixel_hz * slower / _FEWER if slower else None
    return LatePlace(late.axis, late.pixel, hz, most * share // _FEWER, most)


def refusal(lines: Sequence[Line], world: LineConditions) -> str:
    """Return why the board is not guaranteed to follow the lines; empty: it is."""
    rate = boards.load(world.board).tick_hz
    locked = settings.locks({"sync": world.sync})
    refuse_periods(world.pixel_hz, world.divider, rate, locked=locked)
    late = judge(lines, world)
    if late is None:
        return ""
    return f"{lines[late.axis].name}: {NAME} at pixel {late.pixel}: {reason(late, lines, world)}"


def reason(late: LatePlace, lines: Sequence[Line], world: LineConditions) -> str:
    """Return in words why the board may be late, and what it would follow."""
    label = boards.load(world.board).label
    cures = []
    if late.hz:
        cures.append(f"{float(late.hz):.4g} Hz with these counts")
    if late.steps:
        cures.append(f"{late.steps} steps/px in place of {late.most_steps}")
    together = f" of {len(lines)} together" if len(lines) > 1 else ""
    hz_text = f"{float(world.pixel_hz):.6g} Hz"
    late_text = (
        f"{world.baud} baud may bring the counts of this line{together} too late at {hz_text}; "
        if _starved(lines, world)
        else f"the {label} may be too late with this line{together} at {hz_text}; "
    )
    return late_text + (f"it follows {' or '.join(cures)}" if cures else "no slower clock helps")


def findings(lines: Sequence[Line], world: LineConditions) -> list[Finding]:
    """Return where the board may be late with these lines together, as a check of lines does."""
    late = judge(lines, world)
    if late is None:
        return []
    return [Finding(NAME, ERROR, late.pixel, reason(late, lines, world))]


def refuse(lines: Sequence[Line], world: LineConditions, advice: str = "") -> None:
    """Raise RefusedError for lines that the board is not guaranteed to follow."""
    if text := refusal(lines, world):
        raise RefusedError(f"{text}{f'; {advice}' if advice else ''}")


def highest(most: int, fits: Callable[[int], bool]) -> int:
    """Return the highest count up to `most` that fits, by bisection; 0: none."""
    low, high = 0, most + 1
    while high - low > 1 + low // 64:
        middle = (low + high) // 2
        if fits(middle):
            low = middle
        else:
            high = middle
    return low


def decode_of(motion: str) -> str:
    """Return whose lines show a motion: plain or smooth ones."""
    return PLAIN if motion == "constant" else SMOOTH


def line_at(motion: str, steps: int, hz: Fraction, held: int = 0) -> Line:
    """Return a line that shows what a motion costs at so many steps a pixel.

    constant: a plain line. ramp: up at 100,000 steps/s2, so many pixels at this speed, down again.
    smooth: there every pixel accelerates or brakes. By default they are held for two seconds: how a
    board fares with pixels that differ may show late. They are those of `pixstep bench`.
    """
    held = held or max(_LEAST_PX, math.ceil(_HELD_S * hz))
    if decode_of(motion) == PLAIN:
        return Line((steps,) * held, PLAIN, name=motion)
    peak_steps = max(2, steps // 2 * 2)
    up = [0]
    while up[-1] < peak_steps:
        even = 2 * round(len(up) * _RAMP_STEPS_S2 / (hz * hz) / 2)
        up.append(min(peak_steps, max(up[-1] + 2, even)))
    peak = [peak_steps] * held
    if motion == "smooth":
        low = max(0, peak_steps - 4 * max(1, peak_steps // 100))
        peak = [low, (low + peak_steps) // 4 * 2, peak_steps] * math.ceil(held / 3)
    speeds = [*up, peak_steps, *peak, *reversed(up)]
    return Line(tuple((a + b) // 2 for a, b in pairwise(speeds)), SMOOTH, name=motion)


def rate(motion: str, axes: int, world: LineConditions, most: int) -> int:
    """Return the most steps a pixel, up to `most`, that so many axes at once are guaranteed.

    Of a smooth line it is even. The bus must also bring the counts of longer lines than those that
    are tried. Which part of a line comes first depends on its speed, so that a slower line may be
    late where a faster one is not. That is so in narrow ranges; below a wider one the rate ends.
    """
    stride = 1 if decode_of(motion) == PLAIN else 2

    def fits(steps: int) -> bool:
        return not _starves(motion, steps, axes, world) and follows(
            [line_at(motion, steps, world.pixel_hz)] * axes, world
        )

    found = highest(most, fits) // stride * stride
    while late := _late_range(found, stride, fits):
        found = highest(late - stride, fits) // stride * stride
    return found


def _late_range(found: int, stride: int, fits: Callable[[int], bool]) -> int:
    """Return the lowest rate of a range that is late; 0: no two neighbours among those tried are.

    They lie between a half of what is found and that.
    """
    parts = range(_SLOWER, 2 * _SLOWER)
    tried = sorted({found * part // (2 * _SLOWER) // stride * stride for part in parts} - {0})
    late = [not fits(steps) for steps in tried]
    ranges = zip(tried, pairwise(late), strict=False)
    return next((steps for steps, both in ranges if all(both)), 0)


def _starves(motion: str, steps: int, axes: int, world: LineConditions) -> bool:
    """Whether a long line takes more counts than the bus brings: of pixels that differ it may."""
    if motion != "smooth":
        return False
    return bool(_starved([line_at(motion, steps, world.pixel_hz, _LONG_PX)] * axes, world))


def bound_by(found: int, motion: str, axes: int, world: LineConditions, most: int) -> str:
    """Return what keeps a guaranteed rate, `found`, from being higher.

    interrupt: the shortest interval of the step interrupt. bus: with a silent one it would be
    higher by a tenth. ring: the main loop has time, but cannot look further ahead. processor.
    """
    if found >= most - most // 64 - 1:
        return "interrupt"
    if _starves(motion, found + max(2, found // 32), axes, world):
        return "bus"
    beyond = [line_at(motion, found + max(2, found // 32), world.pixel_hz)] * axes
    if _too_close(beyond, world):
        return "interrupt"
    if follows(
        [line_at(motion, found + max(2, found // 10), world.pixel_hz)] * axes,
        replace(world, baud=300),
    ):
        return "bus"
    late = first_late(beyond, world)
    return "processor" if late is None or late.busy > _BUSY else "ring"


def _cut(line: Line, pixels: int) -> Line:
    return replace(line, counts=line.counts[:pixels])


def _is_even(line: Line) -> bool:
    """Whether no train begins behind slower steps: curves are none, and all else is one speed."""
    return line.smooth or len({abs(count) for count in line.counts}) <= 1


def _fastest(line: Line) -> int:
    return max(map(abs, line.speeds if line.smooth else line.counts), default=0)


def _slower(line: Line, part: int) -> Line:
    """Return the line with so many 64ths of its counts; a smooth one keeps even speeds."""
    if not line.smooth:
        return replace(line, counts=tuple(int(count * part / _FEWER) for count in line.counts))
    speeds = [speed * part // _FEWER // 2 * 2 for speed in line.speeds]
    counts = tuple((a + b) // 2 for a, b in pairwise(speeds))
    keeps = line.backlash if max(speeds, default=0) > line.backlash else 0
    return replace(line, counts=counts, backlash=keeps)
