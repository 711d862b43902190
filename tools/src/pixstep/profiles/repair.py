# SPDX-License-Identifier: MIT
"""Repair counts that a smooth motor cannot follow, above all those that make it oscillate.

The repair plans boundary speeds, not counts. Every run of equal counts is a stretch of constant
speed (an odd one is lowered to the even speed below), zero pixels are rest, and what lies between
two stretches is a ramp. A ramp that leads exactly from one speed to the other stays as it is;
any other one is planned anew. A ramp with too few pixels takes them from the faster of the two
stretches, so that the line keeps its length, or they are inserted.
"""

from dataclasses import dataclass
from itertools import pairwise

from pixstep.errors import RefusedError, UserError
from pixstep.lines import line_check
from pixstep.lines.line import Line
from pixstep.profiles import ramps
from pixstep.profiles.generator import MAX_SPEED
from pixstep.profiles.stretches import LINE, Stretch, consumed_pair, split


@dataclass(frozen=True)
class Change:
    """Values replaced from a 1-based pixel (or record) of the original on, and why."""

    pixel: int
    before: tuple[int, ...]
    after: tuple[int, ...]
    reason: str


@dataclass(frozen=True)
class Repair:
    """The repaired values and what was changed."""

    values: tuple[int, ...]
    changes: tuple[Change, ...]


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
    _refuse_range(counts)
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


def _refuse_range(counts: tuple[int, ...]) -> None:
    for pixel, count in enumerate(counts, 1):
        if not 0 <= count <= MAX_SPEED:
            raise RefusedError(
                f"pixel {pixel}: count {count} is outside 0..{MAX_SPEED}: no smooth motor makes it"
            )


def _ramp_blocks(stretches: list[Stretch], between: list[list[int]], wish: Wish) -> list[_Block]:
    """Plan all ramps anew."""
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
    """Say why a ramp does not do as it is."""
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
        raise UserError(
            f"pixel {stretch.pixel}: getting to {stretch.speed} and on{limit} takes {needed} of "
            f"its {len(stretch.counts)} pixels, one must be left: --insert makes the line longer"
        )


def _stretch_block(stretch: Stretch) -> _Block:
    """Return the constant pixels that are left."""
    kept = stretch.kept
    reason = ""
    if kept and kept[0] != stretch.speed:
        reason = f"{kept[0]} is odd, no boundary speed can equal it; {stretch.speed} can"
    return _Block(stretch.pixel + stretch.first, kept, [stretch.speed] * len(kept), reason)


def _assemble(blocks: list[_Block]) -> Repair:
    """Turn the speeds of all blocks into counts, and note where they differ from the original."""
    speeds = [0, *(speed for block in blocks for speed in block.speeds)]
    _flatten(speeds)
    counts = [(low + high) // 2 for low, high in pairwise(speeds)]
    changes = []
    done = 0
    for block in blocks:
        after = tuple(counts[done : done + len(block.speeds)])
        done += len(after)
        if after != block.counts:
            changes.append(_trimmed(block, after))
    return Repair(tuple(counts), tuple(changes))


def _trimmed(block: _Block, after: tuple[int, ...]) -> Change:
    """Return the change of a block, without the equal counts at its ends if the length stays."""
    before = block.counts
    first, end = 0, len(before)
    if len(after) == len(before):
        differ = [k for k in range(end) if before[k] != after[k]]
        first, end = differ[0], differ[-1] + 1
        after = after[first:end]
    reason = block.reason or "two pixels of one count at a peak would swing"
    return Change(block.pixel + first, before[first:end], after, reason)


def _flatten(speeds: list[int]) -> None:
    """Level every peak between two equal speeds: its two equal counts would be an oscillation."""
    for k in range(1, len(speeds) - 1):
        if speeds[k - 1] == speeds[k + 1]:
            speeds[k] = speeds[k - 1]


def _prove(values: tuple[int, ...], counts: tuple[int, ...], wish: Wish) -> None:
    """Refuse a result that no longer moves or that the line check would refuse."""
    if any(counts) and not any(values):
        raise RefusedError("too short to move: a smooth line needs 3 pixels from rest to rest")
    limits = line_check.Limits(max_acceleration=wish.max_acceleration)
    line = Line(whole_line(values, wish.part))
    found = line_check.without_idle_pixel(line_check.check(line, limits))
    if found:
        raise RefusedError(f"no repair found: pixel {found[0].pixel}: {found[0].message}")
