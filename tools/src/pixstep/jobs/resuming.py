# SPDX-License-Identifier: MIT
"""After a run that was broken off: what became of each line, and which positions hold.

Nothing is guessed. A board that kept its memory says by counters and position which lines it made.
One that was reset, or does not answer, leaves the lines that were in flight unknown: at most two.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum

from pixstep.board import registers as regs
from pixstep.board import run, settings
from pixstep.board.errors import BoardError, EmergencyStoppedError, LineLostError, NoReplyError
from pixstep.jobs import account, run_log
from pixstep.jobs.account import LinePlace
from pixstep.jobs.job import Job
from pixstep.jobs.run_log import Event, History
from pixstep.jobs.stations import Station, has_lost_tag
from pixstep.machine.files import MachineFile

_POLL_S = 0.1
_BEGINS_S = 1.0  # from arming to line zero, where somebody has said go
_CLOCK_S = 1.0  # in which a board that has begun just now sees its pixel clock


class Fate(Enum):
    """What became of a line that was in flight."""

    PRINTED = "printed"
    LEFT = run_log.NOT_PRINTED
    BROKEN = "broken"
    UNKNOWN = run_log.UNKNOWN


@dataclass(frozen=True)
class BoardAtResume:
    """A board as it is found: `place` is where its axes are, None if it does not say.

    `trusted` if its positions hold: it kept its memory, and stopped at rest at a line's end.
    """

    station: Station
    place: LinePlace | None
    trusted: bool
    text: str
    reset: bool = False


@dataclass(frozen=True)
class LineInFlight:
    """A line that was in flight."""

    number: int
    fate: Fate
    text: str


@dataclass
class ResumeVerdict:
    """What was found: a row a board, and the lines that were in flight.

    `disagree` if boards that kept their memory have made different lines.
    """

    boards: list[BoardAtResume]
    lines: list[LineInFlight] = field(default_factory=list)
    disagree: bool = False

    @property
    def asked(self) -> list[LineInFlight]:
        """The lines that somebody has to decide about."""
        return [one for one in self.lines if one.fate in (Fate.BROKEN, Fate.UNKNOWN)]

    @property
    def to_home(self) -> list[str]:
        """The motors whose positions do not hold."""
        return [name for one in self.boards if not one.trusted for name in one.station.motors]


def await_rest(stations: Iterable[Station], most_s: float) -> None:
    """Wait until boards have ended what they have queued; raises BoardError if they do not.

    Asking keeps them from falling silent, so that they end at the end of a line. Lines that are
    armed and do not begin are discarded: nobody will let them go any more.
    """
    for station in stations:
        with contextlib.suppress(NoReplyError, LineLostError):
            _await_board(station, most_s)


def _await_board(station: Station, most_s: float) -> None:
    board, world = station.board, station.link.world
    begun_s = world.now_s()
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


def judge(job: Job, told: History, stations: Iterable[Station]) -> ResumeVerdict:
    """Look at the boards; return what became of the lines in flight.

    What boards have said before stays: they may have been homed, or reset, since.
    """
    found = [_found(job, told, station) for station in stations]
    lines = [
        LineInFlight(number, Fate(told.found[number][0]), told.found[number][1])
        if number in told.found else _line(job, number, found)
        for number in told.in_flight
    ]  # fmt: skip
    made = {one.place.line for one in found if one.place and not one.reset}
    return ResumeVerdict(found, lines, disagree=len(made) > 1)


def known_of(verdict: ResumeVerdict) -> list[Event]:
    """Return the lines in flight of which boards know what became, as the log has them."""
    return [
        {"line": one.number, "fate": one.fate.value, "text": one.text}
        for one in verdict.lines if one.fate is not Fate.UNKNOWN
    ]  # fmt: skip


def troubles(machine: MachineFile, stations: Iterable[Station]) -> Iterator[str]:
    """Yield what keeps boards that answer from printing: emergency stop, fault, no pixel clock."""
    for station in stations:
        board = station.board
        with contextlib.suppress(NoReplyError, LineLostError):
            status = regs.flags(board.input("status"))
            if status["estop"]:
                yield f"board {station.name}: {EmergencyStoppedError.ADVICE}"
            elif status["fault"]:
                yield f"board {station.name}: {board.fault_advice()}"
            if _needs_clock(machine) and not _has_clock(station):
                yield f"board {station.name}: no pixel clock comes"


def _needs_clock(machine: MachineFile) -> bool:
    """Whether edges come all the time, from a source that no board of the machine is."""
    clock = machine.clock
    wanted = settings.of_clock(clock.sync, clock.edges).get("sync") != regs.SYNCS["free"]
    made = any(board.clock_out_hz for board in machine.boards.values())
    return wanted and not (clock.gate_edges or made)


def _has_clock(station: Station) -> bool:
    board, world = station.board, station.link.world
    end_s = world.now_s() + _CLOCK_S
    while not regs.flags(board.input("status"))["clock"]:
        if world.now_s() > end_s:
            return False
        world.wait(_POLL_S)
    return True


def discard_left(stations: Iterable[Station]) -> None:
    """Discard lines that wait in queues of boards at rest: nobody lets them go any more."""
    for station in stations:
        with contextlib.suppress(BoardError):
            states = run.states(station.board, station.lines.axes).values()
            if {"loaded", "loading", "refused"} & {*states}:
                run.discard(station.lines)


def clear(station: Station) -> None:
    """Discard what is queued on a board, so that it takes lines again."""
    run.discard(station.lines)


def _found(job: Job, told: History, station: Station) -> BoardAtResume:
    try:
        run.look(station.lines)
        lost_tag = has_lost_tag(station.board, told.tags.get(station.name, 0))
    except BoardError as error:
        return _without_place(station, f"does not answer: {error}")
    positions = ", ".join(f"{name} at {steps}" for name, steps in station.positions.items())
    station.bases = {name: told.bases[name] for name in station.motors if name in told.bases}
    axes = station.axes() if station.bases else []
    if told.chain and (lost_tag or any(axis.has_gone_back for axis in axes)):
        return _without_place(station, f"was reset since; {positions}", reset=True)
    most = max([*told.in_flight, *told.printed, told.chain - 1]) - told.chain + 1
    if any(axis.counted > (most if told.chain else 0) for axis in axes):
        return _without_place(station, f"has made lines that are not in the log; {positions}")
    if not told.chain:
        text = f"rests before line {told.next_line}; {positions}"
        return BoardAtResume(station, None, trusted=True, text=text)
    place = account.place_of_board([account.place_of(job, told.chain, axis) for axis in axes])
    if not place:
        return _without_place(station, f"does not say in which line it is; {positions}")
    if not place.pixel:
        text = f"rests at the end of line {place.line - 1}; {positions}"
        return BoardAtResume(station, place, trusted=True, text=text)
    moved = (axis.now["pixel"] for axis in axes if axis.state not in account.ENDED)
    place = LinePlace(place.line, max([place.pixel, *moved]))
    text = f"stopped in line {place.line} at pixel {place.pixel}; {positions}"
    return BoardAtResume(station, place, trusted=False, text=text)


def _without_place(station: Station, text: str, *, reset: bool = False) -> BoardAtResume:
    """Return a board of which nobody knows where in the job its axes are."""
    return BoardAtResume(station, None, trusted=False, text=text, reset=reset)


def _line(job: Job, number: int, found: Iterable[BoardAtResume]) -> LineInFlight:
    """Return what became of a line, by all boards."""
    boards = [*found]
    fates = {_fate(number, one.place) for one in boards}
    if fates == {Fate.PRINTED}:
        return LineInFlight(number, Fate.PRINTED, "printed")
    if fates == {Fate.LEFT}:
        return LineInFlight(number, Fate.LEFT, "not printed")
    if Fate.UNKNOWN in fates:
        silent = ", ".join(one.station.name for one in boards if one.place is None)
        return LineInFlight(
            number, Fate.UNKNOWN, f"unknown: board {silent} does not know it any more"
        )
    if Fate.BROKEN not in fates:
        made = ", ".join(
            one.station.name for one in boards if _fate(number, one.place) is Fate.PRINTED
        )
        return LineInFlight(number, Fate.BROKEN, f"broken: made by board {made} alone")
    pixel = min(_pixel(job, number, one.place) for one in boards if one.place)
    return LineInFlight(number, Fate.BROKEN, f"broken at pixel {pixel} of {job.pixels}")


def _fate(number: int, place: LinePlace | None) -> Fate:
    if place is None:
        return Fate.UNKNOWN
    if place.line > number:
        return Fate.PRINTED
    return Fate.BROKEN if place.line == number and place.pixel else Fate.LEFT


def _pixel(job: Job, number: int, place: LinePlace) -> int:
    if place.line > number:
        return job.pixels
    return place.pixel if place.line == number else 0
