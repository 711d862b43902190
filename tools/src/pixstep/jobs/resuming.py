# SPDX-License-Identifier: MIT
"""After a run that was broken off: what became of each line, and which positions hold.

Nothing is guessed. A board that kept its memory says by counters and position which lines it made.
One that was reset, or does not answer, leaves the lines that were in flight unknown: at most two.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum

from pixstep.board import registers as regs
from pixstep.board import run
from pixstep.board.errors import BoardError, LineLostError, NoReplyError
from pixstep.board.link import World
from pixstep.jobs import account, tag
from pixstep.jobs.account import Place
from pixstep.jobs.history import History
from pixstep.jobs.job import Job
from pixstep.jobs.stations import Station

_POLL_S = 0.1
_BEGINS_S = 1.0  # from arming to line zero, where somebody has said go


class Fate(Enum):
    """What became of a line that was in flight."""

    PRINTED = "printed"
    LEFT = "not printed"
    BROKEN = "broken"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class Found:
    """A board as it is found: `place` is where its axes are, None if it does not say.

    `trusted` if its positions hold: it kept its memory, and stopped at rest at a line's end.
    """

    station: Station
    place: Place | None
    trusted: bool
    text: str
    reset: bool = False


@dataclass(frozen=True)
class Line:
    """A line that was in flight."""

    number: int
    fate: Fate
    text: str


@dataclass
class Verdict:
    """What was found: a row a board, and the lines that were in flight.

    `disagree` if boards that kept their memory have made different lines.
    """

    boards: list[Found]
    lines: list[Line] = field(default_factory=list)
    disagree: bool = False

    @property
    def asked(self) -> list[Line]:
        """The lines that somebody has to decide about."""
        return [one for one in self.lines if one.fate in (Fate.BROKEN, Fate.UNKNOWN)]

    @property
    def to_home(self) -> list[str]:
        """The motors whose positions do not hold."""
        return [name for one in self.boards if not one.trusted for name in one.station.motors]


def await_rest(stations: Iterable[Station], world: World, most_s: float) -> None:
    """Wait until boards have ended what they have queued; raises BoardError if they do not.

    Asking keeps them from falling silent, so that they end at the end of a line. Lines that are
    armed and do not begin are discarded: nobody will let them go any more.
    """
    for station in stations:
        with contextlib.suppress(NoReplyError, LineLostError):
            _await_board(station, world, most_s)


def _await_board(station: Station, world: World, most_s: float) -> None:
    board, begun_s = station.board, world.now_s()
    while board.moving():
        waited_s = world.now_s() - begun_s
        if waited_s > _BEGINS_S and not regs.flags(board.input("status"))["running"]:
            run.discard(station.lines)
        elif waited_s > most_s:
            raise BoardError(
                f"board {board.unit} moves, longer than two lines take: another program drives "
                f"it, or stop it (`pixstep board stop`)"
            )
        world.wait(_POLL_S)


def judge(job: Job, told: History, stations: Iterable[Station]) -> Verdict:
    """Look at the boards; return what became of the lines in flight."""
    found = [_found(job, told, station) for station in stations]
    lines = [_line(job, number, told.chain, found) for number in told.in_flight]
    made = {one.place.line for one in found if one.place and not one.reset}
    return Verdict(found, lines, disagree=len(made) > 1)


def discard_left(stations: Iterable[Station]) -> None:
    """Discard lines that wait in queues of boards at rest: nobody lets them go any more."""
    for station in stations:
        with contextlib.suppress(BoardError):
            states = run.states(station.board, station.lines.axes).values()
            if {"loaded", "loading", "refused"} & {*states}:
                run.discard(station.lines)


def clear(station: Station) -> None:
    """Clear a board's fault and discard what is queued, so that it takes lines again."""
    run.discard(station.lines)
    if station.board.fault_name():
        run.command(station.board, "clear_fault", station.lines.axes)


def _found(job: Job, told: History, station: Station) -> Found:
    try:
        run.look(station.lines)
        reset = _was_reset(told, station)
    except BoardError as error:
        return Found(station, None, trusted=False, text=f"does not answer: {error}")
    positions = ", ".join(f"{name} at {steps}" for name, steps in station.positions.items())
    if told.chain and reset:
        return Found(station, None, trusted=False, reset=True, text=f"was reset since; {positions}")
    station.bases = {name: told.bases[name] for name in station.motors if name in told.bases}
    axes = station.axes() if station.bases else []
    most = max([*told.in_flight, *told.printed, told.chain - 1]) - told.chain + 1
    most = most if told.chain else 0
    if any(axis.counted > most for axis in axes):
        return Found(
            station, None, trusted=False,
            text=f"has made lines that are not in the log; {positions}",
        )  # fmt: skip
    if not told.chain:
        return Found(
            station, None, trusted=True, text=f"rests before line {told.next_line}; {positions}"
        )
    made = told.printed - told.skipped
    least = max([number + 1 for number in made if number >= told.chain], default=0)
    places = account.common([account.places(job, told.chain, axis, least) for axis in axes])
    if len(places) != 1:
        return Found(
            station, None, trusted=False, text=f"does not say in which line it is; {positions}"
        )
    place = places[0]
    moved = max(place.pixel, *(axis.now["pixel"] if not _at_end(axis) else 0 for axis in axes))
    if not place.pixel:
        text = f"rests at the end of line {place.line - 1}; {positions}"
        return Found(station, place, trusted=True, text=text)
    text = f"stopped in line {place.line} at pixel {moved}; {positions}"
    return Found(station, Place(place.line, moved), trusted=False, text=text)


def _was_reset(told: History, station: Station) -> bool:
    """Return whether a board was reset since the chain began, or may have been.

    A board without a tag is known by its counters alone, as far as they were above 0.
    """
    wanted = told.tags.get(station.name, 0)
    if tag.is_lost(station.board, wanted):
        return True
    axes = [
        account.Axis(name, told.bases[name], station.lines.seen[axis])
        for name, axis in station.motors.items()
        if name in told.bases
    ]
    if any(axis.has_gone_back for axis in axes):
        return True
    return not wanted and any(axis.now["next_block"] == 0 for axis in axes)


def _at_end(axis: account.Axis) -> bool:
    return axis.state in account.ENDED


def _line(job: Job, number: int, chain: int, found: Iterable[Found]) -> Line:
    """Return what became of a line, by all boards."""
    boards = [*found]
    fates = {_fate(number, one.place) for one in boards}
    if fates == {Fate.PRINTED}:
        return Line(number, Fate.PRINTED, "printed")
    if fates == {Fate.LEFT}:
        return Line(number, Fate.LEFT, "not printed")
    if Fate.UNKNOWN in fates:
        silent = ", ".join(one.station.name for one in boards if one.place is None)
        return Line(number, Fate.UNKNOWN, f"unknown: board {silent} does not know it any more")
    if Fate.BROKEN not in fates:
        made = ", ".join(
            one.station.name for one in boards if _fate(number, one.place) is Fate.PRINTED
        )
        return Line(number, Fate.BROKEN, f"broken: made by board {made} alone")
    pixel = min(_pixel(job, number, one.place) for one in boards if one.place)
    return Line(number, Fate.BROKEN, f"broken at pixel {pixel} of {job.pixels}")


def _fate(number: int, place: Place | None) -> Fate:
    if place is None:
        return Fate.UNKNOWN
    if place.line > number:
        return Fate.PRINTED
    return Fate.BROKEN if place.line == number and place.pixel else Fate.LEFT


def _pixel(job: Job, number: int, place: Place) -> int:
    if place.line > number:
        return job.pixels
    return place.pixel if place.line == number else 0
