# SPDX-License-Identifier: MIT
"""Values that a smooth motor cannot follow, repaired: counts of a line, speeds of a PRN.

Counts: the repair plans boundary speeds, not counts. Every run of equal counts is a stretch of
constant speed (an odd one is lowered to the even speed below), zero pixels are rest, and what lies
between two stretches is a ramp. A ramp that leads exactly from one speed to the other stays as it
is; any other one is planned again. A ramp with too few pixels takes them from the faster of the two
stretches, so that the line keeps its length, or they are inserted.

Speeds: the nearest legal profile is taken, whose speeds are even, above 0 and never fall.
"""

import heapq
from dataclasses import dataclass
from itertools import groupby, pairwise

from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.lines import line_check
from pixstep.lines.line import Line
from pixstep.profiles import ramps
from pixstep.profiles.generator import MAX_SPEED

LINE = "line"
START = "start"


@dataclass
class Stretch:
    """Pixels of constant speed; or the `free` end of an accelerating part, at any speed."""

    speed: int
    pixel: int
    counts: tuple[int, ...] = ()
    first: int = 0  # pixels that the ramp before takes
    last: int = 0  # pixels that the ramp behind takes
    free: bool = False

    @property
    def kept(self) -> tuple[int, ...]:
        """The pixels left."""
        return self.counts[self.first : len(self.counts) - self.last]

    @property
    def rests(self) -> bool:
        """True for pixels at rest."""
        return self.speed == 0 and not self.free


def split(counts: tuple[int, ...], part: str) -> tuple[list[Stretch], list[list[int]]]:
    """Return the stretches, rest at both ends included, and the counts between them."""
    stretches = [Stretch(0, 1)]
    between: list[list[int]] = [[]]
    pixel = 1
    for count, group in groupby(counts):
        length = len(list(group))
        if count == 0 and pixel == 1:
            stretches[0].counts = (0,) * length
        elif count == 0 or length > 1:
            speed = 2 if count == 1 else count // 2 * 2
            stretches.append(Stretch(speed, pixel, (count,) * length))
            between.append([])
        else:
            between[-1].append(count)
        pixel += length
    if between[-1] or (part == LINE and stretches[-1].speed):
        stretches.append(Stretch(0, pixel, free=part != LINE))
    return stretches, between


def consumed_pair(stretches: list[Stretch]) -> int | None:
    """Return the index of two equal counts that the ramps took and that need not be a stretch.

    Between moving stretches two equal counts are more likely an accident of a ramp.
    """
    for index in range(1, len(stretches) - 1):
        pair = stretches[index]
        beside_rest = stretches[index - 1].rests or stretches[index + 1].rests
        if len(pair.counts) == 2 and not pair.kept and not beside_rest:
            return index
    return None


@dataclass(frozen=True)
class ValueChange:
    """Values replaced from a 1-based pixel (or record) of the original on, and why."""

    pixel: int
    before: tuple[int, ...]
    after: tuple[int, ...]
    reason: str


@dataclass(frozen=True)
class Repair:
    """The repaired values and what was changed."""

    values: tuple[int, ...]
    changes: tuple[ValueChange, ...]


@dataclass(frozen=True)
class Wish:
    """How to repair: the acceleration limit in steps/pixel2 (even, None: any), the kind of file.

    `part` is LINE for a line from rest to rest, START for an accelerating part that goes on at the
    speed it ends with. With `insert` missing pixels are inserted.
    """

    max_acceleration: int | None = None
    part: str = LINE
    insert: bool = False


@dataclass
class _Block:
    """Pixels of the original, the speeds at the ends of those that replace them, and why."""

    pixel: int
    counts: tuple[int, ...]
    speeds: list[int]
    reason: str


def repair_counts(counts: tuple[int, ...], wish: Wish) -> Repair:
    """Return counts that a smooth motor follows, and the changes made.

    Raises UserError for a count out of range, and if the pixels do not suffice.
    """
    for pixel, count in enumerate(counts, 1):
        if not 0 <= count <= MAX_SPEED:
            raise RefusedError(
                f"pixel {pixel}: count {count} is outside 0..{MAX_SPEED}: no smooth motor makes it"
            )
    stretches, between = split(counts, wish.part)
    blocks = _ramp_blocks(stretches, between, wish)
    while (pair := consumed_pair(stretches)) is not None:
        inside = stretches.pop(pair).counts
        between[pair - 1 : pair + 1] = [[*between[pair - 1], *inside, *between[pair]]]
        blocks = _ramp_blocks(stretches, between, wish)
    for number, stretch in enumerate(stretches):
        _refuse_consumed(stretch, wish)
        blocks.insert(2 * number, _stretch_block(stretch))
    repair = _assemble(blocks)
    _prove(repair.values, counts, wish)
    return repair


def whole_line(values: tuple[int, ...], part: str) -> tuple[int, ...]:
    """Return a line from rest to rest: an accelerating part goes on, then the same mirrored."""
    if part == LINE:
        return tuple(values)
    top = ramps.decoded(0, values)[-1]
    return (*values, top, top, *reversed(values)) if top > 0 else tuple(values)


def _ramp_blocks(stretches: list[Stretch], between: list[list[int]], wish: Wish) -> list[_Block]:
    for stretch in stretches:
        stretch.first = stretch.last = 0
    joints = zip(stretches, between, stretches[1:], strict=False)
    return [_ramp_block(left, inside, right, wish) for left, inside, right in joints]


def _ramp_block(left: Stretch, inside: list[int], right: Stretch, wish: Wish) -> _Block:
    """Plan what leads from one stretch to the next, taking or inserting missing pixels."""
    limit = wish.max_acceleration
    end = None if right.free else right.speed
    ramp = ramps.Ramp(tuple(inside), left.speed, end, limit)
    pixel = right.pixel - len(inside)
    if ramps.follows(ramp):
        return _Block(pixel, ramp.counts, ramps.decoded(left.speed, ramp.counts), "")
    needed = len(inside)
    if end is not None:
        needed = max(needed, ramps.pixels_needed(left.speed, end, limit))
    missing = needed - len(inside)
    if not missing:
        return _Block(pixel, ramp.counts, ramps.plan(ramp), _reason(left, ramp, right))
    speeds = ramps.spread(left.speed, right.speed, needed)
    reason = _reason(left, ramp, right)
    if wish.insert:
        return _Block(pixel, ramp.counts, speeds, reason)
    if right.speed > left.speed:
        right.first = missing
        return _Block(pixel, ramp.counts + right.counts[:missing], speeds, reason)
    left.last = missing
    return _Block(pixel - missing, left.counts[-missing:] + ramp.counts, speeds, reason)


def _reason(left: Stretch, ramp: ramps.Ramp, right: Stretch) -> str:
    limit = ramp.max_acceleration
    within = f" within {limit} steps/px2" if limit else ""
    if ramp.end is None:
        return f"the counts do not go on from speed {ramp.begin} without reversing{within}"
    if not ramp.counts and right.speed:
        count = right.counts[0]
        return (
            f"{len(right.counts)} pixels of {count} entered at speed {left.speed} would swing "
            f"between {2 * count - left.speed} and {left.speed}"
        )
    if not ramp.counts:
        return f"the line would end at speed {left.speed}, not at rest"
    ends = ramps.decoded(ramp.begin, ramp.counts)
    if ends[-1] == ramp.end and min(ends) >= 0:
        return f"from speed {ramp.begin} to {ramp.end}{within}"
    return f"the counts lead from speed {ramp.begin} to {ends[-1]}, not to {ramp.end}"


def _refuse_consumed(stretch: Stretch, wish: Wish) -> None:
    """Refuse a moving stretch of which the ramps leave nothing."""
    if stretch.speed and stretch.counts and not stretch.kept:
        needed = stretch.first + stretch.last
        limit = f" within {wish.max_acceleration} steps/px2" if wish.max_acceleration else ""
        raise UserError(AskedText(
            f"pixel {stretch.pixel}: getting to {stretch.speed} and on{limit} takes {needed} of "
            f"its {len(stretch.counts)} pixels, one must be left: {{insert}} makes the line longer"
        ))  # fmt: skip


def _stretch_block(stretch: Stretch) -> _Block:
    kept = stretch.kept
    reason = ""
    if kept and kept[0] != stretch.speed:
        reason = f"{kept[0]} is odd, no boundary speed can equal it; {stretch.speed} can"
    return _Block(stretch.pixel + stretch.first, kept, [stretch.speed] * len(kept), reason)


def _assemble(blocks: list[_Block]) -> Repair:
    """Turn the speeds of all blocks into counts, and note where they differ from the original."""
    speeds = [0, *(speed for block in blocks for speed in block.speeds)]
    for k in range(1, len(speeds) - 1):
        if speeds[k - 1] == speeds[k + 1]:  # the two equal counts of a peak would oscillate
            speeds[k] = speeds[k - 1]
    counts = [(low + high) // 2 for low, high in pairwise(speeds)]
    changes = []
    done = 0
    for block in blocks:
        after = tuple(counts[done : done + len(block.speeds)])
        done += len(after)
        if after != block.counts:
            changes.append(_trimmed(block, after))
    return Repair(tuple(counts), tuple(changes))


def _trimmed(block: _Block, after: tuple[int, ...]) -> ValueChange:
    """Return the change of a block, without the equal counts at its ends if the length stays."""
    before = block.counts
    first, end = 0, len(before)
    if len(after) == len(before):
        differ = [k for k in range(end) if before[k] != after[k]]
        first, end = differ[0], differ[-1] + 1
        after = after[first:end]
    reason = block.reason or "two pixels of one count at a peak would swing"
    return ValueChange(block.pixel + first, before[first:end], after, reason)


def _prove(values: tuple[int, ...], counts: tuple[int, ...], wish: Wish) -> None:
    if any(counts) and not any(values):
        raise RefusedError("too short to move: a smooth line needs 3 pixels from rest to rest")
    limits = line_check.Limits(max_acceleration=wish.max_acceleration)
    line = Line(whole_line(values, wish.part))
    found = line_check.without_idle_pixel(line_check.check(line, limits))
    if found:
        raise RefusedError(f"no repair found: pixel {found[0].pixel}: {found[0].message}")


def repair_speeds(speeds: tuple[int, ...]) -> Repair:
    """Return the legal profile with the least sum of changes, and the changes, one a record.

    Of equally near ones the lowest is taken.
    """
    nearest = _nearest(speeds)
    changes = []
    highest = 0
    for record, (old, new) in enumerate(zip(speeds, nearest, strict=True), 1):
        if old != new:
            changes.append(ValueChange(record, (old,), (new,), _speed_reason(old, highest)))
        highest = max(highest, old)
    return Repair(nearest, tuple(changes))


def _nearest(speeds: tuple[int, ...]) -> tuple[int, ...]:
    """Least-change non-decreasing even sequence, in units of two.

    The cost of record i as a function of its value is convex with corners at the even neighbours
    of the speed. The heap holds the corners left of the minimum of the cost so far, where a lower
    value may be kept for a later record at no cost: its top is the lowest best value.
    """
    corners: list[int] = []  # negated: heapq keeps the smallest on top
    best = []
    for speed in speeds:
        heapq.heappush(corners, -(speed // 2))
        heapq.heappush(corners, -((speed + 1) // 2))
        heapq.heappop(corners)
        best.append(-corners[0])
    for k in range(len(best) - 2, -1, -1):
        best[k] = min(best[k], best[k + 1])
    return tuple(min(max(2 * value, 2), MAX_SPEED) for value in best)


def _speed_reason(speed: int, highest: int) -> str:
    """Say what is wrong with a record, or that another one's neighbourhood moves it."""
    if speed == 0:
        return "a speed must be above 0"
    if speed > MAX_SPEED:
        return f"above {MAX_SPEED}, the largest speed that a board takes"
    if speed < highest:
        return f"falls below {highest}"
    return "odd: every boundary speed is even" if speed % 2 else "a later record falls below it"
