# SPDX-License-Identifier: MIT
"""Marks: where one instant lies in the counts of clock edges of several boards.

A broadcast `mark` makes every board note when the command ended, by its own time. Everybody hears
that end at the same instant, so that it is found in each board's count of clock edges, and tells
how many edges the counts of two boards differ by.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.link import World

_MARK_S = 0.02  # from a broadcast until every board has served it
POLL_S = 0.02
AGREE = 0.3  # two boards see one edge where they differ by so much of a period, or less
TRIES = 6
COUNT = 0x10000  # numbers of edges are taken modulo this
TICKS = 1 << 32  # and instants modulo this
_SINCE_TICKS = 1 << 26  # some seconds: a mark is looked at within so long
UNIT_TICKS = 64  # of registers mark_units and started_units
_MEASURING_EDGES = 8
REST_S = 120.0  # the longest rest of the clock that is waited for


@dataclass(frozen=True)
class EdgeCount:
    """A board's count of its clock's edges, at one moment.

    `edge` is the number of the newest edge, `edge_ticks` when it came, `expected_ticks` when a lock
    expects the next one, `mark_ticks` when the last mark ended, since the board's timers started.
    """

    edge: int
    edge_ticks: int
    expected_ticks: int
    mark_ticks: int
    zero_edge: int
    marks: int
    steady: bool

    @property
    def none_since(self) -> bool:
        """Whether no edge has come since the mark."""
        return (self.edge_ticks - self.mark_ticks) % TICKS > _SINCE_TICKS


@dataclass(frozen=True)
class Mark:
    """Where the end of a mark lies in a board's count of clock edges.

    `place` is in edges, a number with a fraction; of a clock that rests the edge that it lies
    behind. `steady`: since the mark before this one every edge had come as it should.
    """

    place: float
    rests: bool
    steady: bool
    period_ticks: float
    zero_edge: int

    @property
    def counted(self) -> float:
        """How far behind line zero of the board's newest line that is, in edges."""
        return (self.place - self.zero_edge) % COUNT


def number(first: Mark, mark: Mark, ahead: int) -> int:
    """Return the number that a board has for the edge so far behind the first board's mark."""
    return (math.floor(first.place) + ahead + round(mark.place - first.place)) % COUNT


def offsets(marks: Sequence[Mark]) -> list[float]:
    """Return how many edges more than the first board each has counted, modulo 65536."""
    return [(mark.place - marks[0].place) % COUNT for mark in marks]


def same_state(marks: Sequence[Mark]) -> bool:
    """True if the clock runs for all of them, or for none."""
    return len({mark.rests for mark in marks}) == 1


def take(boards: Sequence[Device], world: World) -> list[Mark]:
    """Make all boards mark, and find where the mark lies in the count of each."""
    before, _, now = _marked(boards, world)
    return [_placed(board, *looks) for board, *looks in zip(boards, before, now, strict=True)]


def resting(boards: Sequence[Device], world: World, ahead: int = 0) -> list[Mark]:
    """Return marks of boards whose gated clock rests: the next edge is the first one of a burst.

    The edge that comes so far `ahead` has a number on each board: 0 names none. Raises BoardError
    if no mark meets a rest.
    """
    end_s = world.now_s() + REST_S
    while True:
        marks = in_rest(boards, world)
        if marks and not (ahead and any(number(marks[0], mark, ahead) == 0 for mark in marks)):
            return marks
        if world.now_s() > end_s:
            raise BoardError(
                f"the gated pixel clock did not rest at any mark in {REST_S:g} s: lines of "
                f"several boards begin together only in rests that are long enough to agree in"
            )
        world.wait(POLL_S)


def agreed(boards: Sequence[Device], world: World) -> list[Mark]:
    """Return marks that show the same edges; raises BoardError if the boards see different ones."""
    for _ in range(TRIES):
        marks = of_one_state(boards, world)
        places = [mark.place - marks[0].place for mark in marks]
        if all(abs(place - round(place)) <= AGREE for place in places):
            return marks
        world.wait(POLL_S)
    for board, place in zip(boards, places, strict=True):
        off = abs(place - round(place))
        if off > AGREE:
            raise BoardError(
                f"boards {boards[0].unit} and {board.unit} see clock edges {off:.2f} periods "
                f"apart: are they on one pixel clock?"
            )
    return marks


def of_one_state(boards: Sequence[Device], world: World) -> list[Mark]:
    """Return marks of boards whose clock runs everywhere, or rests everywhere."""
    for _ in range(TRIES):
        marks = take(boards, world)
        if same_state(marks):
            return marks
        world.wait(POLL_S)
    running = [board.unit for board, mark in zip(boards, marks, strict=True) if not mark.rests]
    still = [board.unit for board, mark in zip(boards, marks, strict=True) if mark.rests]
    raise BoardError(
        f"the pixel clock runs at {_units(running)} and rests at {_units(still)}: check its wires"
    )


def _units(units: Sequence[int]) -> str:
    """Return boards in words."""
    return ("board " if len(units) == 1 else "boards ") + ", ".join(map(str, units))


def in_rest(boards: Sequence[Device], world: World) -> list[Mark] | None:
    """Return marks of boards whose clock rests from the mark until all have been looked at.

    No board has seen an edge since the mark, and behind the mark the first one says that the clock
    rests: the newest edge of each is the same one, the last of a burst. None if that is not so.
    """
    before, rests, now = _marked(boards, world)
    if not rests or not all(look.none_since for look in now):
        return None
    return [
        Mark(look.edge, True, was.steady, _period(board), look.zero_edge)
        for board, was, look in zip(boards, before, now, strict=True)
    ]


def broadcast(board: Device, world: World) -> float:
    """Make all boards on a board's bus mark; return when that was sent, in the world's seconds."""
    with board.modbus.turns:  # nothing may follow the broadcast on the bus
        sent_s = world.now_s()
        board.mark()
        world.wait(_MARK_S)
    return sent_s


def _marked(
    boards: Sequence[Device], world: World
) -> tuple[list[EdgeCount], bool, list[EdgeCount]]:
    """Make all boards mark; return looks before and behind it.

    Between the mark and the looks behind it the first board was asked whether the clock rests.
    """
    before = [_look(board) for board in boards]
    for _ in range(TRIES):
        broadcast(boards[0], world)
        rests = not _clock_runs(boards[0])
        now = [_look(board) for board in boards]
        heard = [
            (look.marks - was.marks) % 0x100 == 1 for was, look in zip(before, now, strict=True)
        ]
        if all(heard):
            return before, rests, now
        before = now
    unit = next(board.unit for board, ok in zip(boards, heard, strict=True) if not ok)
    raise BoardError(f"board {unit}: it does not hear broadcasts, by which boards agree on an edge")


def _clock_runs(board: Device) -> bool:
    """Whether the pixel clock is there."""
    return bool(regs.flags(board.input("status"))["clock"])


def _look(board: Device) -> EdgeCount:
    """Read a board's count of edges, all of it as it is at one moment."""
    found = board.inputs_from("mark_units", "clock_expected_ticks")
    return EdgeCount(
        found["clock_edge"],
        found["clock_edge_ticks"],
        found["clock_expected_ticks"],
        UNIT_TICKS * (found["mark_units"] - found["started_units"]) % TICKS,
        found["zero_edge"],
        found["mark_count"],
        bool(found["mark_steady"]),
    )


def _period(board: Device) -> float:
    """Return the clock's period by the board's settings, ticks."""
    return float(Fraction(board.tick_hz()) / board.clock_hz())


def _placed(board: Device, before: EdgeCount, now: EdgeCount) -> Mark:
    """Return where a mark lies, by looks at the board before and behind it."""
    rests = not _clock_runs(board)
    # A lock knows best where the next edge is.
    locked = board.setting("sync") == regs.SYNCS["lock"]
    was_ticks, is_ticks = (
        look.expected_ticks if locked else look.edge_ticks for look in (before, now)
    )
    period = _period(board)
    edges = (now.edge - before.edge) % COUNT
    # Of a fast clock what it has done just now says more than what it is set to.
    if not rests and _MEASURING_EDGES <= edges < COUNT // 2:
        period = ((is_ticks - was_ticks) % TICKS) / edges
    behind = _signed(now.mark_ticks - is_ticks) / period
    place = now.edge if rests else now.edge + locked + behind
    return Mark(place % COUNT, rests, before.steady, period, now.zero_edge)


def _signed(ticks: int) -> int:
    """Return a difference of two instants, which count modulo 2^32."""
    return (ticks + TICKS // 2) % TICKS - TICKS // 2
