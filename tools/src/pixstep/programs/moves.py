# SPDX-License-Identifier: MIT
"""From words to moves: modes, times and distances in counts, a move at a time.

A circle becomes segments that are blended over their whole length.
"""

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from pixstep.errors import AskedText
from pixstep.programs.expressions import Variables
from pixstep.programs.language import SET, ProgramError, ProgramRow, ProgramWord
from pixstep.programs.motors import Setup

MOST_OFF_STEPS = 0.5  # that segments may leave a circle by, whatever the tolerance of corners
_NOISE = 1e-9  # of the radius: ends that are nearer than this are one place


class Arc(NamedTuple):
    """A part of a circle: centre, radii at both ends, first angle and signed angle to the end.

    The radius runs linearly over the angle from the one to the other. `off` is how far the arc
    leaves the circle that the program asks for.
    """

    centre: tuple[float, float]
    radius: float
    last_radius: float
    first: float
    angle: float
    end: tuple[float, float]
    off: float

    @property
    def length(self) -> float:
        """How long it is, but for the square of the small difference between the radii."""
        return (self.radius + self.last_radius) / 2 * abs(self.angle)

    def point(self, share: float, stretch: float = 1.0) -> tuple[float, float]:
        """Return the place at a share of the angle, the radius there multiplied by `stretch`."""
        radius = (self.radius + (self.last_radius - self.radius) * share) * stretch
        angle = self.first + self.angle * share
        return (
            self.centre[0] + radius * math.cos(angle),
            self.centre[1] + radius * math.sin(angle),
        )


class ArcRequest(NamedTuple):
    """What a line says of a circle: `way` is 1 counterclockwise, -1 clockwise.

    A program has its places in a few decimals, so that no circle leads exactly through both ends:
    `tolerance` is how far the path may leave a circle for that, in the program's unit `unit`.
    """

    begin: tuple[float, float]
    end: tuple[float, float]
    way: int
    values: dict[str, float]
    tolerance: float
    unit: str

    def solved(self) -> Arc:
        """Return the circle. Raises ValueError saying what is wrong with it."""
        if "R" in self.values and self.values.keys() & {"I", "J"}:
            raise ValueError("a circle has a radius R or a centre I, J, not both")
        centre = self._by_radius() if "R" in self.values else self._by_centre()
        first = math.atan2(self.begin[1] - centre[1], self.begin[0] - centre[0])
        last = math.atan2(self.end[1] - centre[1], self.end[0] - centre[0])
        radius, last_radius = math.dist(self.begin, centre), math.dist(self.end, centre)
        angle = (last - first) * self.way % math.tau
        if math.dist(self.begin, self.end) <= _NOISE * radius or angle == 0:
            angle = math.tau
        off = abs(last_radius - radius) / 2
        if "R" in self.values:
            off = abs(radius - abs(self.values["R"]))
        return Arc(centre, radius, last_radius, first, angle * self.way, self.end, off)

    def _by_centre(self) -> tuple[float, float]:
        if not self.values.keys() & {"I", "J"}:
            raise ValueError("a circle needs a radius R or a centre I, J (from where it begins)")
        centre = (
            self.begin[0] + self.values.get("I", 0.0),
            self.begin[1] + self.values.get("J", 0.0),
        )
        radius, other = math.dist(self.begin, centre), math.dist(self.end, centre)
        if radius == 0:
            raise ValueError("the radius of the circle is 0")
        self._require(
            abs(other - radius) / 2,
            radius,
            f"the circle begins at radius {radius:.9g} and ends at radius {other:.9g}",
        )
        return centre

    def _by_radius(self) -> tuple[float, float]:
        """Return the centre: of R above 0 for the shorter way, below 0 for the longer one."""
        radius, chord = self.values["R"], math.dist(self.begin, self.end)
        if chord == 0:
            raise ValueError("a whole circle needs a centre I, J")
        if abs(radius) < chord / 2:
            self._require(
                chord / 2 - abs(radius),
                chord,
                f"radius {radius:.9g} is too short: the ends are {chord:.9g} apart",
            )
        high = math.sqrt(max(0.0, radius**2 - chord**2 / 4)) * self.way
        side = high if radius > 0 else -high
        (x0, y0), (x1, y1) = self.begin, self.end
        return (
            (x0 + x1) / 2 - side * (y1 - y0) / chord,
            (y0 + y1) / 2 + side * (x1 - x0) / chord,
        )

    def _require(self, off: float, size: float, text: str) -> None:
        """Raise ValueError if a path has to leave a circle of some size by too much."""
        if off <= max(self.tolerance, _NOISE * size):
            return
        digit = 10.0 ** (math.floor(math.log10(off)) - 1)
        enough = math.ceil(off / digit) * digit
        text = (
            f"{text}, {off:.3g} {self.unit} off a circle, and {self.tolerance:.3g} {self.unit} "
            f"are allowed"
        )
        cure = f"{enough:.2g}{self.unit}"
        raise ValueError(AskedText("{text}: {arc_tolerance} {cure} takes it", text=text, cure=cure))


def segments_of(arc: Arc, scale: float, most: float, at_least: float) -> int:
    """Return into how many segments an arc is divided, so that they leave it by `most` steps.

    `scale` is steps for its unit. They leave it at both ends. The first one has its second corner
    outside and begins on the circle: its line cuts off an arc of 3/4 of its angle, which is 9/32 of
    the radius times the square of half a segment high. A single one cuts off all of its angle.
    """
    bend = max(arc.radius, arc.last_radius) * scale * arc.angle**2
    if at_least <= 1 and bend <= 8 * most:
        return 1
    angle = abs(arc.angle)
    return math.ceil(max(at_least, math.sqrt(bend * 9 / 128 / most), angle / _WIDEST, 2))


def arc_points(arc: Arc, segments: int) -> Iterator[tuple[float, float]]:
    """Yield the corners of the segments, the last of them the circle's end.

    Segments that are blended over their whole length make parabolas, which pass a corner at an
    eighth of its bend. Corners that lie 1/cos(half a segment) outside put the parabolas on the
    circle, but for the fourth power of the angle.
    """
    stretch = 1 / math.cos(arc.angle / segments / 2)
    for number in range(1, segments):
        yield arc.point(number / segments, stretch)
    yield arc.end


_WIDEST = math.radians(15)


MOST_MS = 2**23 - 1  # of TA, TS, TM and DWELL
_MOST_COUNTS = 2**31  # either way, from where the program begins
_DEFAULT_TS = 50.0
_LEAST_MS = 0.5  # a move's time where segmentation takes the place of acceleration times


class ProgramMove(NamedTuple):
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

    def events(self, rows: Iterable[ProgramRow]) -> Iterator[ProgramMove | Dwell]:
        """Yield what happens. Raises ProgramError naming the first mistake."""
        for row in rows:
            self._line = row.number
            yield from self._row(row)

    def _row(self, row: ProgramRow) -> Iterator[ProgramMove | Dwell]:
        """Yield what a line does: its words of motion together make one move."""
        words: dict[str, ProgramWord] = {}
        after: list[ProgramWord] = []
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

    def _wrong(self, item: ProgramWord, text: str) -> ProgramError:
        where = f"{self.name}:{self._line}:{item.column}: {item.text}"
        return ProgramError(AskedText("{where}: {text}", where=where, text=text))

    def _valued(self, item: ProgramWord) -> ProgramWord:
        try:
            return item.valued(self._variables)
        except ValueError as error:
            raise self._wrong(item, str(error)) from None

    # Modes

    def _set(self, item: ProgramWord) -> None:
        assert item.variable is not None  # it is a SET
        letter, number = item.variable
        try:
            self._variables.write(letter, number(self._variables), item.value)
        except ValueError as error:
            raise self._wrong(item, str(error)) from None

    def _straight(self, item: ProgramWord) -> None:
        self._arc = 0
        self._rapid = item.name == "RAPID"

    def _circle(self, item: ProgramWord) -> None:
        if not self._circles:
            raise self._wrong(item, AskedText("mode1 plans no circles: plan with {mode} lookahead"))
        if not self.setup.segment_ms:
            raise self._wrong(
                item,
                AskedText(
                    "a circle is made of segments: {segment} 5ms, or segment_time in [program] of "
                    "the machine file"
                ),
            )
        if not {"X", "Y"} <= self.setup.words.keys():
            raise self._wrong(item, "a circle needs motors X and Y")
        self._arc = -1 if item.name == "CIRCLE1" else 1
        self._rapid = False

    def _axis_mode(self, item: ProgramWord) -> None:
        chosen = [self._axis(item, word) for word in item.axes] or range(len(self._incremental))
        for index in chosen:
            self._incremental[index] = item.name == "INC"

    def _frax(self, item: ProgramWord) -> None:
        chosen = [self._axis(item, word) for word in item.axes]
        self._feed_axes = chosen or list(range(len(self._units)))

    def _axis(self, item: ProgramWord, word: str) -> int:
        if word not in self.setup.words:
            raise self._wrong(item, f"no motor has the word {word}")
        return self.setup.words[word]

    def _milliseconds(self, item: ProgramWord) -> None:
        if not 0 <= item.value <= MOST_MS:
            raise self._wrong(item, f"is not in the range 0 to {MOST_MS} ms")
        if item.name == "TA":
            self._ta = float(math.floor(item.value + 0.5))
        elif item.name == "TS":
            self._ts = float(math.floor(item.value + 0.5))
        else:
            self._time, self._feed = item.value, None

    def _feedrate(self, item: ProgramWord) -> None:
        if not item.value > 0:
            raise self._wrong(item, "a feed rate is above 0")
        top = self.setup.top_feed
        self._feed = min(item.value, top) if top else item.value
        self._time = None

    # Motion

    def _pause(self, item: ProgramWord) -> ProgramMove | Dwell:
        if not 0 <= item.value <= MOST_MS:
            raise self._wrong(item, f"is not in the range 0 to {MOST_MS} ms")
        if item.name == "DWELL":
            return Dwell(self._line, item.value)
        ta, ts = self._acceleration(item)
        return ProgramMove(
            self._line, self._counts(self._units), max(item.value, _LEAST_MS), ta, ts
        )

    def _acceleration(self, item: ProgramWord) -> tuple[float, float]:
        """Return TA and TS in force; TA is at least twice TS, and not 0."""
        ta = max(self._ta, 2 * self._ts)
        if ta == 0 and not self.setup.segment_ms:
            raise self._wrong(item, "TA and TS are 0: the acceleration would be infinite")
        return max(ta, _LEAST_MS), self._ts

    def _motion(self, words: dict[str, ProgramWord]) -> Iterator[ProgramMove | Dwell]:
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
            tm = self._move_time(first, target, None)
            yield ProgramMove(self._line, self._counts(target), tm, ta, ts)
        self._units = target

    def _rapidly(self, target: list[float]) -> Iterator[ProgramMove | Dwell]:
        """Yield a straight move as fast as the motors can, from rest to rest."""
        here, end, pixel = self._counts(self._units), self._counts(target), self.setup.pixel_ms
        tm, gain = _LEAST_MS, 0.0
        for motor, begin, place in zip(self.setup.motors, here, end, strict=True):
            length, most = abs(place - begin), motor.planned_acceleration(pixel)
            tm = max(tm, length / motor.planned_speed(pixel), math.sqrt(length / most))
            gain = max(gain, length / most)
        ta = max(gain / tm, _LEAST_MS)
        rest = Dwell(self._line, 0.0)
        yield from (rest, ProgramMove(self._line, end, tm, ta, 0.0), rest)

    def _circular(
        self, words: dict[str, ProgramWord], target: list[float], ta: float
    ) -> Iterator[ProgramMove]:
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
            raise self._wrong(first, error.args[0]) from None
        tm = self._move_time(first, target, arc.length)
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
            yield ProgramMove(self._line, self._counts(place), each, blend, 0.0, True, number - 1)

    def _move_time(self, item: ProgramWord, target: list[float], arc: float | None) -> float:
        """Return the time of a move, from TM or from F; `arc` is the length of a circle."""
        if self._time is not None:
            return max(self._time, _LEAST_MS)
        tm = self._time_units(item, target, arc) * self.setup.feed_ms
        if tm > MOST_MS:
            raise self._wrong(item, f"takes {tm:.6g} ms, beyond {MOST_MS}")
        return max(tm, _LEAST_MS)

    def _time_units(self, item: ProgramWord, target: list[float], arc: float | None) -> float:
        """Return the time of a move by the feed rates, in their unit of time."""
        if self._feed is None:
            raise self._wrong(item, "neither TM nor F says how fast")
        length = [abs(end - begin) for end, begin in zip(target, self._units, strict=True)]
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
