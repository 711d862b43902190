# SPDX-License-Identifier: MIT
"""How long the main loop stays in one request, and in one round, while axes move.

Cycles of the main program, interrupts not counted: what a board has to do before it looks at its
rings again. Requests of every kind that a host may send are tried one by one, each some times, so
that it meets different moments of a round.
"""

import random
import struct
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial
from typing import Any

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.upload import LineUpload
from pixstep.lines import runs
from pixstep.lines.line import PLAIN, Line
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep_dev.bench import sections
from pixstep_dev.bench.figure import BenchFigure, Task, key
from pixstep_trials import lines

NAME = "turns"
_HZ = Fraction(100)
_RATE = 20_000  # steps/s of all axes together
_SECONDS = 60.0
_TRIES = 6
_MOST = 125  # registers in a read
_READ_INPUTS, _READ_HOLDINGS, _READ_COILS, _READ_DISCRETES, _WRITE, _WRITE_MANY = 4, 3, 1, 2, 6, 16
_IDENTIFY, _READ_FILES, _READ_DEVICE = 17, 20, 43
_RECORDS_FILE, _EVENTS_FILE = 1, 2
_EVENT_WORDS = 120
_COMMANDS = ("arm", "disarm", "mark", "enable", "permit_on", "clear_fault", "discard")

# What goes into the queue of an axis meanwhile: is it smooth, and its counts.
_UP = tuple(range(1, 20, 2))
DATA: dict[str, tuple[bool, tuple[int, ...]]] = {
    "easy": (False, tuple(20 + k % 7 for k in range(800))),
    "turning": (False, (10, -10) * 400),
    "ramps": (True, (*_UP, *reversed(_UP)) * 40),
    "even": (True, (10, *(20,) * 799)),
}
_BLOCKS_BYTES = (48, 120)  # a board takes no more of them than its host sends at once
_BLOCKS = 2

Request = Callable[[], object]


def tasks() -> list[Task]:
    """One task for each board."""
    return [Task(NAME, measure, (board,)) for board in boards.BOARD_NAMES]


def measure(board: str) -> list[dict[str, Any]]:
    """Return the longest request and round of a board for each kind of request."""
    rows = [_row(board, *found) for found in _measured(board, _requests)]
    for name in DATA:
        for size in _BLOCKS_BYTES:
            rows += [_row(board, *found) for found in _measured(board, _block(name, size))]
    return rows


def _row(board: str, request: str, stats: dict[str, Any]) -> dict[str, Any]:
    return {
        "board": board,
        "request": request,
        "request_cycles": sections.longest(stats, "serial"),
        "round_cycles": sections.longest(stats, "round"),
    }


def _measured(
    board: str, requests: Callable[[SimulatedBoard], Iterator[tuple[str, Request, int]]]
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield what a board did during each of some requests while all of its axes move."""
    rng = random.Random(f"turns {board}")
    with SimulatedBoard(board, _HZ) as run:
        moving = list(range(boards.load(board).axes))
        run.set_up(_HZ, moving, bus_timeout_ms=0)
        count = lines.count_at(_RATE // len(moving), _HZ)
        run.load(dict.fromkeys(moving, Line((count,) * int(_SECONDS * _HZ), PLAIN)))
        run.arm()
        run.link.world.wait(0.2)
        for name, request, tries in requests(run):
            run.simulator.mark()
            for _ in range(tries):
                request()
                run.simulator.run(rng.randrange(30_000))
            yield name, run.simulator.stats()["boards"][0]
        assert set(run.states().values()) == {"running"}


def _requests(run: SimulatedBoard) -> Iterator[tuple[str, Request, int]]:
    """Yield all kinds but line data, and but a stop, after which nothing moves."""
    board, axes = run.board, len(run.axes)

    def ask(*pdu: int) -> None:
        run.client.ask(board.unit, bytes(pdu))  # an exception is a reply, too

    def read(function: int, address: int, count: int) -> Request:
        return lambda: ask(function, *struct.pack(">HH", address, count))

    def file(number: int, words: int) -> Request:
        return lambda: ask(_READ_FILES, 7, 6, *struct.pack(">HHH", number, 0, words))

    axes_end = regs.AXIS_BASE + axes * regs.AXIS_STRIDE
    first = board.map.input("fault_mask_high").address
    last = board.map.input("clock_expected_ticks").address + 1
    kinds = {
        "none": lambda: None,
        "the board": read(_READ_INPUTS, 0, regs.AXIS_BASE),
        "the board, more": read(_READ_INPUTS, first, last + 1 - first),
        "an axis": read(_READ_INPUTS, regs.AXIS_BASE, regs.AXIS_STRIDE),
        "board and axes": read(_READ_INPUTS, 0, min(axes_end, _MOST)),
        "room": read(_READ_INPUTS, regs.ROOM_BASE, axes),
        "records": read(_READ_INPUTS, regs.RECORD_BASE, _MOST - 1),
        "records, not whole": read(_READ_INPUTS, regs.RECORD_BASE + 5, _MOST - 3),
        "settings": read(_READ_HOLDINGS, 0, 25),
        "a setting": lambda: ask(_WRITE, 0, 8, 0, 5),
    }
    if board.has("events"):
        kinds["events"] = read(_READ_INPUTS, regs.EVENT_BASE, _EVENT_WORDS)
    if board.has("bits"):
        kinds["discrete inputs"] = read(_READ_DISCRETES, 0, regs.DISCRETE_INPUTS)
        kinds["coils"] = read(_READ_COILS, 0, regs.COIL_PERMIT + 1 if axes == 4 else axes)
    if board.has("diagnosis"):
        kinds["identity"] = lambda: ask(_IDENTIFY)
        kinds["identification"] = lambda: ask(_READ_DEVICE, 14, 1, 0)
    if board.has("files"):
        kinds["file of records"] = file(_RECORDS_FILE, 120)
        kinds["file of events"] = file(_EVENTS_FILE, 100)
    kinds["a spoilt block"] = lambda: ask(_WRITE_MANY, 0x10, 0, 0, 123, 246, *bytes(246))
    for name, request in kinds.items():
        yield name, request, _TRIES
    mask = (1 << axes) - 1
    for name in _COMMANDS:
        words = struct.pack(">HHH", mask, regs.COMMANDS[name], 0)
        pdu = (_WRITE_MANY, *struct.pack(">HHB", regs.COMMAND_BASE, 3, 6), *words)
        yield f"command {name}", partial(ask, *pdu), _TRIES


def _block(name: str, size: int) -> Callable[[SimulatedBoard], Iterator[tuple[str, Request, int]]]:
    """Return what sends blocks of so many bytes of a second line, behind that of axis 0."""
    smooth, counts = DATA[name]
    mark = runs.MARK_START | (runs.MARK_SMOOTH if smooth else 0)

    def requests(run: SimulatedBoard) -> Iterator[tuple[str, Request, int]]:
        upload = LineUpload(run.board, 0, [(mark, 0), (0, 0), *((count, 1) for count in counts)])
        upload.push_into(8)  # the head of the line
        yield f"block of {size} bytes, {name}", lambda: upload.push_into(size), _BLOCKS

    return requests


FIGURE = BenchFigure(
    NAME,
    "The longest stay of the main loop in a request, and in a round, cycles",
    "Cycles of the main program between two looks at the axes, interrupts not counted, while all "
    "axes move plain lines at 20,000 steps/s together. Boards of several axes look after them in "
    "the middle of long requests.",
    tasks,
    (
        key("board", "board", left=True),
        key("request", "request", left=True),
        key("longest stay in it", "request_cycles"),
        key("longest round meanwhile", "round_cycles"),
    ),
)
