# SPDX-License-Identifier: MIT
"""From words to moves: modes, times and distances in counts, a move at a time."""

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from pixstep.programs.arcs import MOST_OFF_STEPS, ArcRequest, arc_points, segments_of
from pixstep.programs.expressions import Variables
from pixstep.programs.language import SET, Item, ProgramError, Row
from pixstep.programs.motors import Setup

MOST_MS = 2**23 - 1  # of TA, TS, TM and DWELL
_MOST_COUNTS = 2**31  # either way, from where the program begins
_DEFAULT_TS = 50.0
_LEAST_MS = 0.5  # a move's time where segmentation takes the place of acceleration times


class Move(NamedTuple):
    """A move as programmed: where it ends in counts, its times in ms.

    `fixed` is a segment of a circle: the time of its blend is the segment's own, not the minimum
    of the move's time; `segment` is its number, 0 for the first one and for what is no circle.
    """

    line: int
    target: tuple[float, ...]
    tm: float
    ta: float
    ts: float
    fixed: bool = False
    segment: int = 0


class Dwell(NamedTuple):
    """A stop of so many ms, with nothing blended over it."""

    line: int
    ms: float


class Program:
    """Reads rows and yields moves and dwells; it knows no more than the state of the language.

    Without `circles` one is a mistake: mode1 has none.
    """

    def __init__(self, name: str, setup: Setup, *, circles: bool = True) -> None:
        self.name, self.setup, self._circles = name, setup, circles
        count = len(setup.motors)
        self._units = [0.0] * count  # where the program is, in the units of each word
        self._incremental = [False] * count
        self._feed_axes = [setup.words[word] for word in "XYZ" if word in setup.words]
        self._ta, self._ts = 0.0, _DEFAULT_TS
        self._time: float | None = None  # TM, or None where F is in force
        self._feed: float | None = None
        self._arc = 0  # 1 counterclockwise, -1 clockwise, 0 straight
        self._rapid = False
        self._line = 0
        self.arc_off_steps = 0.0  # of the arc that leaves its circle the most
        self._variables = Variables()

    def events(self, rows: Iterable[Row]) -> Iterator[Move | Dwell]:
        """Yield what happens. Raises ProgramError naming the first mistake."""
        for row in rows:
            self._line = row.number
            yield from self._row(row)

    def _row(self, row: Row) -> Iterator[Move | Dwell]:
        """Yield what a line does: its words of motion together make one move."""
        words: dict[str, Item] = {}
        after: list[Item] = []
        for said in row.items:
            item = self._valued(said)
            if item.name in _MODES:
                _MODES[item.name](self, item)
            elif item.name in ("DWELL", "DELAY"):
                after.append(item)
            elif item.name in words:
                raise self._wrong(item, "stands twice in a line")
            else:
                words[item.name] = item
        if words:
            yield from self._motion(words)
        for item in after:
            yield self._pause(item)

    def _wrong(self, item: Item, text: str) -> ProgramError:
        return ProgramError(f"{self.name}:{self._line}:{item.column}: {item.text}: {text}")

    def _valued(self, item: Item) -> Item:
        """Return an item with the value that it has now."""
        try:
            return item.valued(self._variables)
        except ValueError as error:
            raise self._wrong(item, str(error)) from None

    # Modes

    def _set(self, item: Item) -> None:
        """Give a variable its value."""
        assert item.variable is not None  # it is a SET
        letter, number = item.variable
        try:
            self._variables.write(letter, number(self._variables), item.value)
        except ValueError as error:
            raise self._wrong(item, str(error)) from None

    def _straight(self, item: Item) -> None:
        self._arc = 0
        self._rapid = item.name == "RAPID"

    def _circle(self, item: Item) -> None:
        if not self._circles:
            raise self._wrong(item, "mode1 plans no circles: plan with --mode lookahead")
        if not self.setup.segment_ms:
            raise self._wrong(
                item,
                "a circle is made of segments: --segment 5ms, or segment_time in [program] of the "
                "machine file",
            )
        if not {"X", "Y"} <= self.setup.words.keys():
            raise self._wrong(item, "a circle needs motors X and Y")
        self._arc = -1 if item.name == "CIRCLE1" else 1
        self._rapid = False

    def _axis_mode(self, item: Item) -> None:
        chosen = [self._axis(item, word) for word in item.axes] or range(len(self._incremental))
        for index in chosen:
            self._incremental[index] = item.name == "INC"

    def _frax(self, item: Item) -> None:
        chosen = [self._axis(item, word) for word in item.axes]
        self._feed_axes = chosen or list(range(len(self._units)))

    def _axis(self, item: Item, word: str) -> int:
        if word not in self.setup.words:
            raise self._wrong(item, f"no motor has the word {word}")
        return self.setup.words[word]

    def _milliseconds(self, item: Item) -> None:
        if not 0 <= item.value <= MOST_MS:
            raise self._wrong(item, f"is not in the range 0 to {MOST_MS} ms")
        if item.name == "TA":
            self._ta = float(math.floor(item.value + 0.5))
        elif item.name == "TS":
            self._ts = float(math.floor(item.value + 0.5))
        else:
            self._time, self._feed = item.value, None

    def _feedrate(self, item: Item) -> None:
        if not item.value > 0:
            raise self._wrong(item, "a feed rate is above 0")
        top = self.setup.top_feed
        self._feed = min(item.value, top) if top else item.value
        self._time = None

    # Motion

    def _pause(self, item: Item) -> Move | Dwell:
        if not 0 <= item.value <= MOST_MS:
            raise self._wrong(item, f"is not in the range 0 to {MOST_MS} ms")
        if item.name == "DWELL":
            return Dwell(self._line, item.value)
        ta, ts = self._acceleration(item)
        return Move(self._line, self._counts(self._units), max(item.value, _LEAST_MS), ta, ts)

    def _acceleration(self, item: Item) -> tuple[float, float]:
        """Return TA and TS in force; TA is at least twice TS, and not 0."""
        ta = max(self._ta, 2 * self._ts)
        if ta == 0 and not self.setup.segment_ms:
            raise self._wrong(item, "TA and TS are 0: the acceleration would be infinite")
        return max(ta, _LEAST_MS), self._ts

    def _motion(self, words: dict[str, Item]) -> Iterator[Move | Dwell]:
        """Yield the move of a line, or the segments of its circle."""
        first = next(iter(words.values()))
        target = list(self._units)
        for word, item in words.items():
            if word in "IJR":
                if not self._arc:
                    raise self._wrong(item, "is a word of circles: CIRCLE1 or CIRCLE2 first")
                continue
            index = self._axis(item, word)
            target[index] = item.value + (target[index] if self._incremental[index] else 0)
            counts = target[index] * self.setup.motors[index].counts_per_unit
            if not abs(counts) < _MOST_COUNTS:
                raise self._wrong(item, f"is {counts:.6g} counts, beyond {_MOST_COUNTS}")
        if self._rapid:
            yield from self._rapidly(target)
            self._units = target
            return
        ta, ts = self._acceleration(first)
        if self._arc:
            yield from self._circular(words, target, ta)
        else:
            length = [abs(end - begin) for end, begin in zip(target, self._units, strict=True)]
            tm = self._move_time(first, length, None)
            yield Move(self._line, self._counts(target), tm, ta, ts)
        self._units = target

    def _rapidly(self, target: list[float]) -> Iterator[Move | Dwell]:
        """Yield a straight move as fast as the motors can, from rest to rest."""
        here, end, pixel = self._counts(self._units), self._counts(target), self.setup.pixel_ms
        tm, gain = _LEAST_MS, 0.0
        for motor, begin, place in zip(self.setup.motors, here, end, strict=True):
            length, most = abs(place - begin), motor.planned_acceleration(pixel)
            tm = max(tm, length / motor.planned_speed(pixel), math.sqrt(length / most))
            gain = max(gain, length / most)
        ta = max(gain / tm, _LEAST_MS)
        rest = Dwell(self._line, 0.0)
        yield from (rest, Move(self._line, end, tm, ta, 0.0), rest)

    def _circular(self, words: dict[str, Item], target: list[float], ta: float) -> Iterator[Move]:
        """Yield the segments of a circle; what is no X and no Y goes along in proportion."""
        x, y = self.setup.words["X"], self.setup.words["Y"]
        first = next(iter(words.values()))
        values = {word: words[word].value for word in "IJR" if word in words}
        begin = (self._units[x], self._units[y])
        scale = max(self.setup.motors[index].counts_per_unit for index in (x, y))
        request = ArcRequest(
            begin, (target[x], target[y]), self._arc, values,
            self.setup.arc_tolerance / scale, self.setup.motors[x].unit,
        )  # fmt: skip
        try:
            arc = request.solved()
        except ValueError as error:
            raise self._wrong(first, str(error)) from None
        length = [abs(end - start) for end, start in zip(target, self._units, strict=True)]
        tm = self._move_time(first, length, arc.length)
        self.arc_off_steps = max(self.arc_off_steps, arc.off * scale)
        off = min(self.setup.path_tolerance, MOST_OFF_STEPS)
        segments = segments_of(arc, scale, off, tm / self.setup.segment_ms)
        each = tm / segments
        before = list(self._units)
        for number, point in enumerate(arc_points(arc, segments), 1):
            share = number / segments
            place = [
                begin + (end - begin) * share for begin, end in zip(before, target, strict=True)
            ]
            place[x], place[y] = point
            blend = min(ta, each) if number == 1 else each
            yield Move(self._line, self._counts(place), each, blend, 0.0, True, number - 1)

    def _move_time(self, item: Item, length: list[float], arc: float | None) -> float:
        """Return the time of a move, from TM or from F; `arc` is the length of a circle."""
        if self._time is not None:
            return max(self._time, _LEAST_MS)
        units = self._time_units(item, length, arc)
        tm = units * self.setup.feed_ms
        if tm > MOST_MS:
            raise self._wrong(item, f"takes {tm:.6g} ms, beyond {MOST_MS}")
        return max(tm, _LEAST_MS)

    def _time_units(self, item: Item, length: list[float], arc: float | None) -> float:
        """Return the time of a move by the feed rates, in their unit of time."""
        if self._feed is None:
            raise self._wrong(item, "neither TM nor F says how fast")
        fed = math.hypot(*(length[index] for index in self._feed_axes)) if arc is None else arc
        rest = max((d for index, d in enumerate(length) if index not in self._feed_axes), default=0)
        other = self.setup.other_feed
        if rest and not fed and not other:
            raise self._wrong(
                item, "only axes without a feed rate move (FRAX): set program.other_feed or use TM"
            )
        return max(fed / self._feed, rest / other if other else 0.0)

    def _counts(self, units: list[float]) -> tuple[float, ...]:
        return tuple(
            [value * m.counts_per_unit for value, m in zip(units, self.setup.motors, strict=True)]
        )


_MODES = {
    SET: Program._set,
    "LINEAR": Program._straight,
    "RAPID": Program._straight,
    "CIRCLE1": Program._circle,
    "CIRCLE2": Program._circle,
    "ABS": Program._axis_mode,
    "INC": Program._axis_mode,
    "FRAX": Program._frax,
    "TA": Program._milliseconds,
    "TS": Program._milliseconds,
    "TM": Program._milliseconds,
    "F": Program._feedrate,
}
