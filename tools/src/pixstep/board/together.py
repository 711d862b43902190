# SPDX-License-Identifier: MIT
"""Lines of several boards that begin on one edge of their common pixel clock.

A mark tells by how many edges the counts of the boards differ (clockmarks.py). `go` then names to
each board, by its own count, the one edge on which all begin. A second mark, before that edge
comes, finds a board that has missed an edge since; a last one after the lines compares what each
has counted. docs/PROTOCOL.md has the procedure step by step.
"""

import contextlib
import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pixstep import signals
from pixstep.board import clock_marks, orders, run, settings, snapshot
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import BoardError, ExceptionReplyError, LineLostError, NoReplyError
from pixstep.board.link import World
from pixstep.board.port import InterruptedBusError
from pixstep.board.run import LinesOfBoard
from pixstep.progress import Progress, unseen

_LEAD_S, _LEAD_BOARD_S = 0.15, 0.1  # from the mark to line zero: go and a second mark come between
_LEAD_EDGES = 3
_READY_S = 10.0
_START_S, _START_PIXELS = 1.0, 4


@dataclass(frozen=True)
class Together:
    """Lines that have begun together, with the token that they were armed with."""

    token: int
    group: list[LinesOfBoard]

    def compare(self, world: World) -> None:
        """Compare the boards' counts of clock edges since line zero.

        Raises BoardError where they differ: a clock edge was lost, false or doubled on one of the
        boards' inputs, whose axes may be some pixels beside the others'.
        """
        boards = [lines.board for lines in self.group]
        if _gate_of(boards):
            _same_counts(boards, [mark.counted for mark in clock_marks.resting(boards, world)])
            return
        for last in range(clock_marks.TRIES):
            marks = clock_marks.take(boards, world)
            counts = [mark.counted for mark in marks]
            if clock_marks.same_state(marks) and max(counts) - min(counts) <= clock_marks.AGREE:
                return
            if clock_marks.same_state(marks) and last >= 1:
                break
            world.wait(clock_marks.POLL_S)
        _same_counts(boards, counts)


def _same_counts(boards: Sequence[Device], counts: Sequence[float]) -> None:
    """Raise BoardError if boards have counted different numbers of clock edges."""
    if max(counts) - min(counts) <= clock_marks.AGREE:
        return
    said = ", ".join(
        f"board {board.unit} {count:.1f}" for board, count in zip(boards, counts, strict=True)
    )
    raise BoardError(
        f"the boards have counted different numbers of clock edges since line zero ({said}): "
        f"an edge was lost, false or doubled at one input; check the clock's wires, home again"
    )


def start(
    group: list[LinesOfBoard], world: World, progress: Progress = unseen, token: int | None = None
) -> Together:
    """Start lines of several boards on one edge of the pixel clock.

    All are armed with a token and have to be ready; then each is told the edge by its own count.
    While the clock rests the boards wait for it, for as long as this function polls them. If a
    board does not arm, is not ready, refuses or faults, if the counts of edges do not fit, or if
    Ctrl-C comes, all are stopped and their lines are forgotten. Raises BoardError then, which names
    the board. Without a `token` one is made at random.
    """
    for lines in group:
        lines.board.require("tokens")
    clocked = _are_clocked([lines.board for lines in group])
    token = token or random.SystemRandom().randrange(1, 0x10000)
    armed: list[LinesOfBoard] = []
    gone = False
    try:
        for lines in group:
            _arm_one(lines, token, armed)
        _await_ready(group, world, clocked=clocked)
        gone = True
        zeros = _agree_and_go(group, token, world) if clocked else _go_at_once(group, token)
        _await_start(group, zeros, world, progress, clocked=clocked)
    except (BoardError, KeyboardInterrupt, InterruptedBusError):
        with signals.ignored():
            _take_back(armed, gone=gone)
        raise
    return Together(token, group)


def _are_clocked(boards: Sequence[Device]) -> bool:
    """Return whether the boards' lines wait for the pixel clock.

    Raises BoardError if some do and others do not, or if a board cannot begin on each edge.
    """
    found = {board: settings.read(board) for board in boards}
    free = [board.unit for board in boards if found[board]["sync"] == regs.SYNCS["free"]]
    if free and len(free) < len(boards):
        clocked = next(board.unit for board in boards if board.unit not in free)
        raise BoardError(
            f"board {free[0]} has sync free and board {clocked} begins on the pixel clock: lines "
            f"that begin together need sync start or lock on every board, or free on every one"
        )
    for board in boards:
        _require_free_grid(board, found[board])
    return not free


def _require_free_grid(board: Device, found: Mapping[str, int]) -> None:
    """Raise BoardError if a board's running lines leave it no choice among the clock's edges."""
    if not (settings.locks(found) and found["divider"] > 1):
        return
    if regs.flags(board.input("status"))["running"]:
        raise BoardError(
            f"board {board.unit}: its other axes run locked to the clock with a divider of "
            f"{found['divider']}, so that it cannot begin on each edge that the boards may agree "
            f"on: start all its axes at once, wait for their end, or use divider 1"
        )


def _arm_one(lines: LinesOfBoard, token: int, armed: list[LinesOfBoard]) -> None:
    """Arm a board's lines and note it; a board that did not say no may be armed too."""
    armed.append(lines)
    try:
        run.arm_lines(lines, token)
    except (NoReplyError, LineLostError):
        raise
    except BoardError:
        armed.remove(lines)
        raise


def _take_back(armed: list[LinesOfBoard], *, gone: bool) -> None:
    """Disarm what was armed, or stop it if it may have been told to go; nobody may begin alone."""
    if not armed:
        return
    if gone:  # each is told once before any is asked again: the edge is near
        run.stop(armed)
        return
    armed[0].board.settle()
    for lines in armed:
        with contextlib.suppress(BoardError):
            lines.board.command("disarm", lines.axes)


def _await_ready(group: list[LinesOfBoard], world: World, *, clocked: bool) -> None:
    """Wait until every board has decoded ahead and knows its clock."""
    waiting = list(group)
    end_s = world.now_s() + _READY_S
    while waiting:
        lines = waiting[0]
        word = lines.board.input("status")
        status = regs.flags(word)
        if status["fault"]:
            run.raise_fault(lines.board)
        if not status["armed"]:
            run.require(lines, ("armed",), "not armed after all")
        if not clocked or lines.board.input("ready"):
            waiting.pop(0)
        elif world.now_s() > end_s:
            raise BoardError(
                f"board {lines.board.unit}: not ready after {_READY_S:g} s: "
                f"{_what_is_not(lines.board, word, world)}"
            )
        else:
            world.wait(clock_marks.POLL_S)


def _what_is_not(board: Device, status: int, world: World) -> str:
    """Return in words what a board is not ready with."""
    if regs.is_measured(status):
        return "its decoder"
    return f"its pixel clock is not measured: {snapshot.clock_beside(board, world)}"


def _go_at_once(group: list[LinesOfBoard], token: int) -> dict[int, int]:
    """Let boards go whose lines wait for no clock, one after the other."""
    for lines in group:
        orders.go(lines.board, token, 1)
    return {}


def _agree_and_go(group: list[LinesOfBoard], token: int, world: World) -> dict[int, int]:
    """Find the edge that all boards begin on, tell it to each, and check that they still agree.

    Returns the older line zero of each unit, of boards on a gated clock alone.
    """
    boards = [lines.board for lines in group]
    gate_edges = _gate_of(boards)
    if gate_edges:
        # While the clock rests: line zero of the next burst.
        ahead = 1 + gate_edges
        marks = clock_marks.resting(boards, world, ahead)
    else:
        marks = clock_marks.agreed(boards, world)
        ahead = _edges_ahead(boards, marks)
    for board, mark in zip(boards, marks, strict=True):
        _go(board, token, clock_marks.number(marks[0], mark, ahead))
    again = (
        clock_marks.in_rest(boards, world)
        if gate_edges
        else clock_marks.of_one_state(boards, world)
    )
    # None: the burst has come, and compare() has the last word.
    if again is not None:
        _check_again(boards, marks, again)
    if not gate_edges:
        return {}
    return {board.unit: mark.zero_edge for board, mark in zip(boards, marks, strict=True)}


def _check_again(
    boards: Sequence[Device], marks: Sequence[clock_marks.Mark], again: Sequence[clock_marks.Mark]
) -> None:
    """Raise BoardError if a board has lost an edge, or seen a false one, between two marks."""
    for board, mark in zip(boards, again, strict=True):
        if not mark.steady and mark.rests == marks[0].rests:
            raise BoardError(
                f"board {board.unit}: its pixel clock was disturbed while the boards agreed on an "
                f"edge: an edge at an odd distance, or a lost one"
            )
    before, now = clock_marks.offsets(marks), clock_marks.offsets(again)
    for board, was, is_now in zip(boards, before, now, strict=True):
        if (
            abs(is_now - was) > clock_marks.AGREE
            and abs(abs(is_now - was) - clock_marks.COUNT) > clock_marks.AGREE
        ):
            raise BoardError(
                f"boards {boards[0].unit} and {board.unit} have counted different numbers of clock "
                f"edges within a moment: one was lost, false or doubled at one input"
            )


def _gate_of(boards: Sequence[Device]) -> int:
    """Return how many edges behind a burst's first one the boards' lines begin; 0: no gate.

    Raises BoardError if they have different gates.
    """
    gates = [settings.gate_of(settings.read(board)) for board in boards]
    for board, edges in zip(boards, gates, strict=True):
        if edges != gates[0]:
            raise BoardError(
                f"board {boards[0].unit} has gate_edges {gates[0]} and board {board.unit} {edges}: "
                f"lines on one gated clock begin on one edge of its burst"
            )
    return gates[0]


def _go(board: Device, token: int, edge: int) -> None:
    """Tell a board its edge; raises BoardError with the reason if it refuses."""
    try:
        orders.go(board, token, edge)
    except ExceptionReplyError:
        run.raise_fault(board)
        raise BoardError(f"board {board.unit}: it refuses to go: none of its axes waits") from None


def _edges_ahead(boards: Sequence[Device], marks: Sequence[clock_marks.Mark]) -> int:
    """Return how many edges behind the mark all begin."""
    lead_s = _LEAD_S + _LEAD_BOARD_S * len(boards)
    clock_s = marks[0].period_ticks / boards[0].tick_hz()
    ahead = math.ceil(lead_s / clock_s) + _LEAD_EDGES
    # 0 names no edge.
    while any(clock_marks.number(marks[0], mark, ahead) == 0 for mark in marks):
        ahead += 1
    return ahead


def _await_start(
    group: list[LinesOfBoard],
    zeros: dict[int, int],
    world: World,
    progress: Progress,
    *,
    clocked: bool,
) -> None:
    """Wait until no axis is armed any more, while the clock rests for as long as it does.

    On a gated clock an axis may already be armed for its next line: there a board has begun when
    its line zero is another one than in `zeros`. Raises BoardError for a fault, if an axis is armed
    although the clock has run for so long that it must have begun, and if the clock rests for
    minutes.
    """
    rests_until_s = world.now_s() + clock_marks.REST_S
    slowest_s = max(lines.board.pixel_period_s() for lines in group)
    end_s: float | None = None
    patience_s = _START_S + _LEAD_S + _LEAD_BOARD_S * len(group)
    while True:
        waiting, clocks, begun = [], [], False
        for lines in group:
            run.raise_fault(lines.board)
            if lines.recorder:
                lines.recorder.look_if_due(world, lines.uploads)
            found = run.states(lines.board, lines.axes)
            armed = [(lines.board.unit, axis) for axis, name in found.items() if name == "armed"]
            unit = lines.board.unit
            if unit in zeros and lines.board.input("zero_edge") != zeros[unit]:
                armed.clear()
            begun = begun or len(armed) < len(found)
            waiting += armed
            clocks.append(regs.flags(lines.board.input("status"))["clock"])
        if not waiting:
            return
        if any(clocks) or begun or not clocked:
            end_s = end_s or world.now_s() + patience_s + (_LEAD_EDGES + _START_PIXELS) * slowest_s
        if end_s is not None and world.now_s() > end_s:
            unit, axis = waiting[0]
            raise BoardError(f"board {unit}: axis {axis} is still armed while the clock runs")
        if end_s is None and world.now_s() > rests_until_s:
            raise BoardError(
                f"the pixel clock has rested for {clock_marks.REST_S:g} s: nothing has moved"
            )
        progress(0.0)
        world.wait(clock_marks.POLL_S)
