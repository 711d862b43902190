# SPDX-License-Identifier: MIT
"""How long the main loop stays in one request, and in one round, while all axes move.

Cycles of the main program, interrupts not counted: what a board has to do before it looks at its
rings again. Requests of every kind that a host may send are tried one by one, each so often that
it meets different moments of a round and of the queues.
"""

import itertools
import random
import struct
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any, Protocol

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep_dev.bench import sections
from pixstep_dev.bench.figure import Figure, Task, key
from pixstep_trials import lines

NAME = "turns"
_HZ = Fraction(100)
_RATE = 20_000  # steps/s of all axes together
_SECONDS = 60.0
_TRIES = 6
_READ_MOST = 125
_EVERY = ("arm", "disarm", "clear_fault", "discard", "enable", "permit_on", "zero", "go", "mark")
_SMOOTH, _PLAIN = 1, 0


class Ask(Protocol):
    """Sends a request to the board and waits for the reply, whatever it is."""

    def __call__(self, *pdu: int) -> None: ...


def tasks() -> list[Task]:
    """One task for each board."""
    return [Task(NAME, measure, (board,)) for board in boards.BOARD_NAMES]


def measure(board: str) -> list[dict[str, Any]]:
    """Measure all requests on one board."""
    return [
        {"board": board, "request": name, "request_cycles": asked, "round_cycles": rounds}
        for name, asked, rounds in _Bench(board).measured()
    ]


class _Bench:
    """A board whose axes all move for longer than the requests take."""

    def __init__(self, board: str) -> None:
        self.board, self.axes = board, boards.load(board).axes
        self.rng = random.Random(f"turns {board}")

    def measured(self) -> Iterator[tuple[str, int, int]]:
        with SimulatedBoard(self.board, _HZ) as run:
            self.run = run
            run.set_up(_HZ, list(range(self.axes)), bus_timeout_ms=0)
            run.talk_at(115_200)
            count = lines.count_at(_RATE // self.axes, _HZ)
            line = Line((count,) * int(_SECONDS * _HZ), PLAIN)
            run.load(dict.fromkeys(range(self.axes), line))
            run.arm()
            run.link.world.wait(0.2)
            for name, request in self.requests():
                run.simulator.mark()
                for _ in range(_TRIES):
                    request()
                    run.simulator.run(self.rng.randrange(30_000))
                stats = run.simulator.stats()["boards"][0]
                longest = stats["section_longest"]
                yield name, longest[4], longest[5]
            states = run.states()
            assert set(states.values()) == {"running"}, states

    def ask(self, *pdu: int) -> None:
        """Ask the board; an exception is a reply, too."""
        self.run.client.ask(1, bytes(pdu))

    def words(self, function: int, address: int, count: int) -> Callable[[], None]:
        """Return a request for so many registers."""
        return lambda: self.ask(function, *struct.pack(">HH", address, count))

    def requests(self) -> Iterator[tuple[str, Callable[[], None]]]:
        """Yield every kind of request by name."""
        board = self.run.board
        most = regs.AXIS_BASE + self.axes * regs.AXIS_STRIDE
        yield "none", lambda: None
        yield "board and all axes", self.words(4, 0, min(most, _READ_MOST))
        yield "all axes", self.words(4, regs.AXIS_BASE, self.axes * regs.AXIS_STRIDE)
        yield "one axis", self.words(4, regs.AXIS_BASE, regs.AXIS_STRIDE)
        yield "board", self.words(4, 0, regs.AXIS_BASE)
        yield "room", self.words(4, regs.ROOM_BASE, self.axes)
        yield "records of an axis", self.words(4, regs.RECORD_BASE, 124)
        yield "records of two axes", self.words(4, regs.RECORD_BASE + 30, 125)
        yield "holdings", self.words(3, 0, 30)
        more = board.map.input("fault_mask_high").address
        yield "more of the board", self.words(4, more, 45)
        yield "positions in a read of two words", self.words(4, regs.AXIS_BASE + 6, 2)
        if board.has("events"):
            yield "events", self.words(4, regs.EVENT_BASE, 120)
        if board.has("bits"):
            yield "discrete inputs", self.words(2, 0, 32)
            yield "coils", self.words(1, 0, 14)
        if board.has("diagnosis"):
            yield "identity", lambda: self.ask(17)
            yield "device", lambda: self.ask(43, 14, 1, 0)
        yield "a setting", lambda: self.ask(6, 0, 8, 0, 5)


FIGURE = Figure(
    NAME,
    "The longest request and round of the main loop, cycles",
    "",
    tasks,
    (
        key("board", "board", left=True),
        key("request", "request", left=True),
        key("request's cycles", "request_cycles"),
        key("round's cycles", "round_cycles"),
    ),
)
