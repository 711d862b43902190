# SPDX-License-Identifier: MIT
"""A search for short patterns of counts that come close to what a board can do: `--search`.

What is guaranteed is a model of the board. Random lines meet its worst errors seldom; a search that
changes a few counts of the patterns that were closest finds them within some hundred.
"""

import random
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise, repeat

from pixstep.board import boards, guarantee
from pixstep.board.capability import PLAIN as PLAIN_KIND
from pixstep.board.capability import SMOOTH as SMOOTH_KIND
from pixstep.board.capability import of as capability_of
from pixstep.lines.line import PLAIN, Line
from pixstep.progress import Progress, unseen
from pixstep.simulation.job import LOCK, START, LineExperiment
from pixstep_dev.guarantee.campaign import CLEAN, REFUSED, ending
from pixstep_dev.guarantee.sets import LEAST_HZ, MOST_HZ, OWN_PX, world_of
from pixstep_trials import lines

# Shares of the guaranteed clock that are run, near it with clocks that are off by so much.
BEYOND, NEAR = (1.0, 1.02, 1.05, 1.1, 1.2, 1.4), 1.02
PPM = (600, -500, 0)
NEVER = 2.0  # a share: no fault as far as was tried
_KEPT = 24  # patterns whose children are tried
_NEW = 0.2  # of those that are tried
_TWO = 0.4  # of new ones have two kinds of lines
_TOPS = (1, 2, 3, 6, 10, 15, 30, 60, 100, 130, 300, 800)
_HELD_PX = 600
_CLOSER = 1.01  # the guaranteed clock is found to 1 %
_AHEAD = 1.4  # times the clock that is refused first, up to which others are tried


@dataclass(frozen=True)
class Pattern:
    """Counts that lines repeat, and the world they run in; `shift`: counts from axis to axis.

    Every other axis repeats the counts `beside`, if there are any, smooth ones or not.
    """

    board: str
    counts: tuple[int, ...]
    smooth: bool
    axes: int
    shift: int
    hz: int
    sync: str
    divider: int
    loaded: bool
    baud: int
    beside: tuple[int, ...] = ()
    beside_smooth: bool = False

    @property
    def _kinds(self) -> list[tuple[tuple[int, ...], bool]]:
        """Counts, and whether they are smooth: those of the axes, by turns."""
        first = (self.counts, self.smooth)
        return [first, (self.beside, self.beside_smooth)] if self.beside else [first]

    def lines(self) -> list[Line]:
        """Return a line for each axis."""
        return [self._line(axis) for axis in range(self.axes)]

    def _line(self, axis: int) -> Line:
        counts, smooth = self._kinds[axis % len(self._kinds)]
        first = axis * self.shift % len(counts)
        counts = counts[first:] + counts[:first]
        often = OWN_PX[self.board] // len(counts)
        often = _HELD_PX if len(counts) == 1 else max(1, often // 2 if smooth else often)
        if not smooth:
            return Line(counts * often, PLAIN, name="pattern")
        speeds = [abs(count) // 2 * 2 + 2 for count in counts] * often
        up, down = (lines.ramp(speed, Fraction(self.hz)) for speed in (speeds[0], speeds[-1]))
        return lines.smooth([*up, *speeds, *reversed(down)])

    def may_run(self) -> bool:
        """Whether the board's limits allow it."""
        if not LEAST_HZ <= self.hz <= MOST_HZ // self.divider:
            return False
        return all(self._kind_may_run(*kind) for kind in self._kinds)

    def _kind_may_run(self, counts: tuple[int, ...], smooth: bool) -> bool:
        clock = {"sync": 2 if self.sync == LOCK else 1, "divider": self.divider}
        able = capability_of(self.board, Fraction(self.hz), axes=self.axes, clock=clock)
        if smooth:
            return max(map(abs, counts)) + 2 <= able.top_speed(SMOOTH_KIND)
        moving = [count for count in counts if count]
        if not moving:
            return False
        turns = (max(abs(a), abs(b)) for a, b in pairwise([*moving, moving[0]]) if a * b < 0)
        return (
            max(map(abs, moving)) <= able.top_speed(PLAIN_KIND)
            and max(turns, default=0) <= 0.97 * able.direct_reversal_speed
        )

    def accepted(self) -> bool:
        """Whether the board is guaranteed to follow it."""
        world = world_of(self.board, self.hz, self.sync, self.baud, self.divider)
        return self.may_run() and guarantee.first_late(self.lines(), world) is None

    def end(self, ppm: int) -> str:
        """Run it; return how it ended."""
        return ending(
            LineExperiment(
                self.board,
                dict(enumerate(self.lines())),
                Fraction(self.hz * self.divider),
                divider=self.divider,
                sync=self.sync,
                pixel_ppm=ppm,
                serial_load=self.loaded,
                baud=self.baud,
            )
        )

    def __str__(self) -> str:
        return (
            f"{self.board}, {self.axes} axes, {' beside '.join(_text(*one) for one in self._kinds)}"
            f" (shift {self.shift}), {self.sync} at {self.hz} Hz"
            f"{f' of {self.divider} edges' if self.divider > 1 else ''}, {self.baud} baud"
            f"{', loaded' if self.loaded else ''}"
        )


@dataclass(frozen=True)
class Close:
    """A pattern at its guaranteed clock, and the share of that at which it ended in a fault."""

    pattern: Pattern
    share: float
    end: str = CLEAN


@dataclass
class Closest:
    """The patterns that came closest, the closest first; `complaints`: accepted, but they fail."""

    found: list[Close] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    @property
    def rows(self) -> list[str]:
        """Return a line for each."""
        return [
            f"{f'{one.share:.0%}' if one.share < NEVER else 'none':>5} {one.pattern}"
            for one in self.found
        ]


def run(
    tries: int, seed: int = 1, names: tuple[str, ...] = (), progress: Progress = unseen
) -> Closest:
    """Try so many patterns of each board."""
    closest = Closest()
    names = names or boards.BOARD_NAMES
    with ProcessPoolExecutor(2) as pool:
        for done, found in enumerate(pool.map(search, names, repeat(tries), repeat(seed)), 1):
            closest.found += found
            progress(done / len(names))
    closest.found.sort(key=lambda one: one.share)
    closest.complaints = [f"{one.pattern}: {one.end}" for one in closest.found if one.share <= 1]
    return closest


def search(board: str, tries: int, seed: int) -> list[Close]:
    """Return the patterns of a board that came closest."""
    some = random.Random(f"{seed} {board}")
    kept: list[Close] = []
    for _ in range(tries):
        fresh = len(kept) < _KEPT // 2 or some.random() < _NEW
        pattern = _any(some, board) if fresh else _child(some, _parent(some, kept))
        highest = _highest(pattern)
        if highest is None:
            continue
        one = _beyond(highest)
        kept = [old for old in kept if _key(old) != _key(one) or old.share < one.share]
        if not any(_key(old) == _key(one) for old in kept):
            kept = sorted([*kept, one], key=lambda found: found.share)[:_KEPT]
    return kept


def _text(counts: tuple[int, ...], smooth: bool) -> str:
    return f"{'smooth' if smooth else 'plain'} {','.join(map(str, counts))}"


def _key(one: Close) -> tuple[tuple[int, ...], tuple[int, ...], int, str]:
    return one.pattern.counts, one.pattern.beside, one.pattern.axes, one.pattern.sync


def _parent(some: random.Random, kept: list[Close]) -> Pattern:
    return min(some.sample(kept, 2), key=lambda one: one.share).pattern


def _any(some: random.Random, board: str) -> Pattern:
    counts = _counts(some)
    most = boards.load(board).axes
    return Pattern(
        board, counts, some.random() < 0.3, some.choice((1, most, some.randint(1, most))),
        some.choice((0, 0, 1, 2)), some.choice((30, 60, 120, 250, 500, 800, 1200, 1800, 2500)),
        some.choice((START, LOCK)), some.choice((1, 1, 1, 2, 3, 8)), some.random() < 0.5,
        some.choice((115_200, 115_200, 500_000)),
        _counts(some) if some.random() < _TWO else (), some.random() < 0.5,
    )  # fmt: skip


def _counts(some: random.Random) -> tuple[int, ...]:
    top = some.choice(_TOPS)
    return tuple(_count(some, top) for _ in range(some.choice((1, 2, 3, 4, 4, 5, 6, 8, 10))))


def _count(some: random.Random, top: int) -> int:
    steps = some.choice((0, 1, 1, 2, 3, top, top, top, some.randint(0, top)))
    return some.choice((-1, 1, 1)) * steps


def _child(some: random.Random, parent: Pattern) -> Pattern:
    """Return a pattern with something changed."""
    most = boards.load(parent.board).axes
    changes: list[dict[str, object]] = [
        {"hz": round(parent.hz * some.choice((0.6, 0.8, 1.25, 1.6)))},
        {"sync": LOCK if parent.sync == START else START},
        {"axes": some.randint(1, most)},
        {"shift": some.randint(0, 3)},
        {"divider": some.choice((1, 2, 3, 4, 8))},
        {"loaded": not parent.loaded},
        {"baud": some.choice((115_200, 250_000, 500_000))},
        {"beside": () if parent.beside else _counts(some)},
        {"beside_smooth": not parent.beside_smooth},
    ]
    if parent.beside and some.random() < 0.35:
        return replace(parent, beside=_changed(some, list(parent.beside)))
    if some.random() < 0.65:
        return replace(parent, counts=_changed(some, list(parent.counts)))
    return replace(parent, **some.choice(changes))  # type: ignore[arg-type]


def _changed(some: random.Random, counts: list[int]) -> tuple[int, ...]:
    k = some.randrange(len(counts))
    near = counts[k]
    kind = some.choice(("other", "other", "more", "fewer", "scaled", "shuffled"))
    if kind == "other":
        counts[k] = some.choice((-near, 0, 1, -1, near + 1, near - 1, near * 2, near // 2))
    elif kind == "more":
        counts.insert(k, some.choice((0, 1, near, -near, some.choice(counts))))
    elif kind == "fewer" and len(counts) > 1:
        del counts[k]
    elif kind == "scaled":
        share = some.choice((0.5, 0.8, 1.25, 2))
        counts = [int(count * share) for count in counts]
    else:
        some.shuffle(counts)
    return tuple(counts)


def _clocks(pattern: Pattern, step: float) -> Iterator[Pattern]:
    hz = float(pattern.hz)
    while LEAST_HZ <= hz <= MOST_HZ:
        yield replace(pattern, hz=round(hz))
        hz *= step


def _highest(pattern: Pattern) -> Pattern | None:
    """Return it at the highest clock near its own that is accepted; None: at none it is.

    Above clocks that are refused there may be others that are accepted, by an error of the model.
    """
    highest = next((one for one in _clocks(pattern, 1 / 1.15) if one.accepted()), None)
    refused_hz = 0
    for one in _clocks(highest, _CLOSER) if highest else ():
        if one.accepted():
            highest = one
        elif one.hz > _AHEAD * (refused_hz := refused_hz or one.hz):
            break
    return highest


def _beyond(pattern: Pattern) -> Close:
    """Run it at its clock and beyond, until it ends in a fault or the board refuses it."""
    for share in BEYOND:
        faster = replace(pattern, hz=round(pattern.hz * share))
        if share > 1 and not faster.may_run():
            break
        for ppm in PPM if share <= NEAR else PPM[:1]:
            end = faster.end(ppm)
            if end.startswith(REFUSED):
                return Close(pattern, NEVER)
            if end != CLEAN:
                return Close(pattern, share, end)
    return Close(pattern, NEVER)
