# SPDX-License-Identifier: MIT
"""Lines of real boards: armed, started together, streamed and followed to their end."""

import contextlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from pixstep import signals
from pixstep.board import boards, orders, settings, snapshot, values
from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import (
    IMPOSSIBLE,
    BoardError,
    EmergencyStoppedError,
    ExceptionReplyError,
    FaultError,
    LineLostError,
    NoReplyError,
    NotPossibleError,
)
from pixstep.board.link import World
from pixstep.board.upload import LineUpload, feed, pause_s
from pixstep.errors import UserError
from pixstep.progress import Progress, unseen

_POLL_S = 0.02
# Of lines that run: between two polls of the status, and between two looks at all of the axes,
# which keeps a board from its steps for some 30,000 cycles.
_STATUS_S, _AXES_S = 0.05, 0.25
_WRAPS = 0x10000  # of lines_done
_OVER = ("done", "loaded")  # a line has ended; "loaded" is the state of the next one
_TOGETHER = "too_fast_together"
_STOP_TRIES = 3
_NOT_STOPPED = "NOT STOPPED as far as is known"
_LAST_STEP_S = 1.0  # the period of a very slow step may be longer
_LOOK_S = 0.05  # between the two positions that show whether an axis rests


class Reader(Protocol):
    """What reads the records of lines while they run."""

    def look_if_due(self, world: World, uploads: list[LineUpload]) -> None:
        """Read what is new, if it is time for that; what is left of lines is sent in between."""

    def look(self, uploads: list[LineUpload], *, ended: bool = False) -> None:
        """Read what is new; `ended` if no line makes any more."""


@dataclass
class LinesOfBoard:
    """The axes of one board that take part, and what is still to be queued of their lines."""

    board: Device
    axes: list[int]
    uploads: list[LineUpload] = field(default_factory=list)
    recorder: Reader | None = None
    # The registers of each axis as they were seen last, by whoever follows the lines.
    seen: Mapping[int, Mapping[str, int]] = field(default_factory=dict)
    # Lines that each axis had finished when its present ones were armed, if that is known.
    before: Mapping[int, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Rest:
    """An axis, looked at twice: its state and position, and whether it still moved."""

    state: str
    position_steps: int
    moved: bool

    @property
    def at_rest(self) -> bool:
        """True if it neither moves nor is about to."""
        return not self.moved and self.state not in regs.MOVING_STATES


def states(board: Device, axes: list[int]) -> dict[int, str]:
    """Return the states of some axes by name."""
    found = board.axes(max(axes) + 1)
    return {axis: regs.axis_state(found[axis]["axis_state"]) for axis in axes}


def look(lines: LinesOfBoard) -> None:
    """Note the registers of the axes as they are now."""
    found = lines.board.axes(max(lines.axes) + 1)
    lines.seen = {axis: found[axis] for axis in lines.axes}


def loaded(board: Device, count: int) -> list[int]:
    """Return the axes of a board that have a line loaded."""
    return [axis for axis, state in states(board, list(range(count))).items() if state == "loaded"]


def arm(
    board: Device, axes: list[int], token: int = 0, known: Sequence[tuple[int, int]] | None = None
) -> None:
    """Arm axes; raises BoardError saying why the board would not.

    If the reply is lost, the axes are looked at: no line begins twice. `known` is as for
    `orders.arm`: the first of its requests is not needed then.
    """
    if token:
        board.require("tokens")
    with _explained(board, "arm", axes):
        orders.arm(board, axes, token, known)


def arm_lines(lines: LinesOfBoard, token: int = 0) -> None:
    """Arm the axes of a group, and note how many lines they have finished before."""
    look(lines)
    lines.before = {axis: found["lines_done"] for axis, found in lines.seen.items()}
    known = [(found["axis_state"], found["lines_done"]) for found in lines.seen.values()]
    arm(lines.board, lines.axes, token, known)


def arm_queued(lines: LinesOfBoard) -> None:
    """Arm lines that have just been queued to run at once.

    If the board refuses that, they are discarded: left in the queue they would run before the next
    ones.
    """
    try:
        arm_lines(lines)
    except BoardError:
        discard(lines)
        raise


def play_unknown(board: Device, axes: list[int]) -> list[int]:
    """Return those of some axes whose newest line with backlash began without knowing the play."""
    status = board.input("status") if axes else 0
    return [axis for axis in axes if status >> (regs.STATUS_PLAY + axis) & 1]


def command(board: Device, name: str, axes: list[int], argument: int = 0) -> None:
    """Give a command; a refusal is explained by the state of the board."""
    with _explained(board, name, axes):
        if name == "clear_fault":
            orders.clear_fault(board)
        else:
            board.command(name, axes, argument)


@contextlib.contextmanager
def _explained(board: Device, name: str, axes: list[int]) -> Iterator[None]:
    """Let the state of the board explain why it refuses a command."""
    try:
        yield
    except ExceptionReplyError as error:
        if error.code != IMPOSSIBLE:
            raise
        raise _why_not(board, name, axes) from None


def follow(
    group: list[LinesOfBoard], world: World, pixels: int = 0, progress: Progress = unseen
) -> None:
    """Stream what is left and wait until all lines are over.

    `pixels` is the length of the longest, for the progress. Raises BoardError for a fault, and for
    a line that was stopped meanwhile. Records of lines that have a recorder are read along.
    """
    try:
        _follow(group, world, pixels, progress)
    except BoardError:
        with contextlib.suppress(BoardError):
            _read_last_records(group)
        raise
    _read_last_records(group)


def _read_last_records(group: list[LinesOfBoard]) -> None:
    for lines in group:
        if lines.recorder:
            lines.recorder.look([], ended=True)


def _follow(group: list[LinesOfBoard], world: World, pixels: int, progress: Progress) -> None:
    streamed = [lines for lines in group if any(not item.done for item in lines.uploads)]
    pixel_s = {lines.board.unit: lines.board.pixel_period_s() for lines in streamed}
    while True:
        look_s = world.now_s() + _AXES_S
        over, done = True, 0
        for lines in group:
            look(lines)
            names = [regs.axis_state(found["axis_state"]) for found in lines.seen.values()]
            over = over and not any(name in regs.MOVING_STATES for name in names)
            done = max(done, *(found["pixel"] for found in lines.seen.values()))
            if "fault" in names:
                raise_fault(lines.board)
        if over:
            break
        progress(min(1.0, done / pixels) if pixels else 0.0)
        _stream(group, world, look_s, pixel_s)
    for lines in group:
        require(lines, _OVER, "stopped before its end")
    _require_all_made(group)


def _require_all_made(group: list[LinesOfBoard]) -> None:
    """Raise BoardError for an axis that has a line loaded which was to follow without a gap.

    Axes that begin together make equally many lines: one that has made fewer, and has the next one
    in its queue, got that one too late. The lines that were sent to an axis are all to be made.
    """
    made = {
        (lines.board.unit, axis): (found["lines_done"] - lines.before[axis]) % _WRAPS
        for lines in group
        for axis, found in lines.seen.items()
        if axis in lines.before
    }
    most = max(made.values(), default=0)
    for lines in group:
        sent = Counter(item.axis for item in lines.uploads)
        for axis, found in lines.seen.items():
            mine = made.get((lines.board.unit, axis))
            wanted = max(most, sent[axis])
            if mine is not None and mine < wanted and _is_loaded(found):
                raise BoardError(
                    f"board {lines.board.unit}: axis {axis} ended after {mine} of {wanted} lines: "
                    f"line {mine + 1} reached its queue too late, and is still there: the axes are "
                    f"no longer in the same line (`pixstep board disarm` discards it)"
                )


def _is_loaded(found: Mapping[str, int]) -> bool:
    return regs.axis_state(found["axis_state"]) == "loaded"


def _stream(
    group: list[LinesOfBoard], world: World, until_s: float, pixel_s: Mapping[int, float]
) -> None:
    """Stream what is left until it is time for a look again, or a board has come to its end.

    `pixel_s` is the pixel period of the boards whose lines are streamed, by unit.
    """
    while True:
        begun_s, rest_s = world.now_s(), _STATUS_S
        for lines in group:
            feed(lines.uploads)
            if lines.recorder:
                lines.recorder.look_if_due(world, lines.uploads)
            rest_s = pause_s(lines.uploads, pixel_s.get(lines.board.unit, 0), rest_s)
        world.wait(max(0.0, begun_s + rest_s - world.now_s()))
        if world.now_s() >= until_s or not all(lines.board.moving() for lines in group):
            return


def stop_axes(board: Device, axes: list[int]) -> None:
    """Stop axes by one request.

    Only if it is not acknowledged, and the board does not say either that nothing moves, it is
    repeated: no axis is stopped twice that has stopped. Raises BoardError if it is never.
    """
    failure = _try_stop(board, axes)
    for _ in range(_STOP_TRIES - 1):
        if failure is None or _known_still(board, axes):
            return
        failure = _try_stop(board, axes)
    if failure and not _known_still(board, axes):
        raise failure


def rests(board: Device, axes: list[int], world: World) -> dict[int, Rest]:
    """Look twice at some axes, a little after the last step of a stop; return what each does."""
    end = world.now_s() + _LAST_STEP_S
    while (stopping := _stopping(board, axes)) and world.now_s() < end:
        world.wait(_POLL_S)
    before = positions(board, axes)
    world.wait(_LOOK_S)
    found = board.axes(max(axes) + 1)
    return {
        axis: Rest(
            regs.axis_state(found[axis]["axis_state"]),
            found[axis]["position_steps"],
            axis in stopping or found[axis]["position_steps"] != before[axis],
        )
        for axis in axes
    }


def stop(group: list[LinesOfBoard]) -> str:
    """Stop all axes of a group, also behind a board that does not answer; return in words how.

    Each board is told once before any is asked again. One that does not acknowledge it is named:
    what it does is not known. Signals are ignored meanwhile.
    """
    with signals.ignored():
        group[0].board.settle()
        return "; ".join(_stop_all(group))


def discard(lines: LinesOfBoard) -> None:
    """Discard what is queued of lines that do not run, as far as the board can be told."""
    with contextlib.suppress(BoardError), lines.board.once():
        lines.board.command("disarm", lines.axes)


@contextlib.contextmanager
def stopped_on_failure(group: list[LinesOfBoard]) -> Iterator[None]:
    """Stop all axes of a group when a signal comes, a board is lost, or this program fails.

    The exception goes on with a note saying where the axes are, a BoardError says so itself. A
    board in fault, or one that refuses, has nothing that moves and is left as it is. Keep this the
    innermost context: no other may fail first.
    """
    try:
        yield
    except UserError:
        raise
    except (NoReplyError, LineLostError) as error:
        error.args = (_beside(error, stop(group)),)
        raise
    except BoardError as error:
        moving = [lines for lines in group if not _known_still(lines.board, lines.axes)]
        if moving:
            error.args = (_beside(error, stop(moving)),)
        raise
    except BaseException as error:
        error.add_note(stop(group))
        raise


def _beside(error: BoardError, stopped: str) -> str:
    """Return an error with what became of the stop: first, where it is not known to have stopped.

    A front end cuts the middle out of a long text.
    """
    if stopped.startswith(_NOT_STOPPED):
        return f"{stopped}; {error}"
    return f"{error} (stopped: {stopped})"


def _stop_all(group: list[LinesOfBoard]) -> list[str]:
    """Stop all axes of a group; return in words how, by board and axis, what failed first."""
    failures = [_try_stop(lines.board, lines.axes) for lines in group]
    told, unknown = [], []
    for lines, failure in zip(group, failures, strict=True):
        try:
            if failure and not _known_still(lines.board, lines.axes):
                stop_axes(lines.board, lines.axes)
            found = positions(lines.board, lines.axes)
            told += [
                f"board {lines.board.unit} axis {axis} at position {steps}"
                for axis, steps in found.items()
            ]
        except BoardError as error:
            unknown.append(f"{_NOT_STOPPED}: {getattr(error, 'brief', error)}")
    return unknown + told


def positions(board: Device, axes: list[int]) -> Mapping[int, int]:
    """Return the positions of some axes, steps."""
    found = board.axes(max(axes) + 1)
    return {axis: found[axis]["position_steps"] for axis in axes}


def _try_stop(board: Device, axes: list[int]) -> BoardError | None:
    """Send one stop; return what went wrong."""
    try:
        with board.once(urgent=True):
            board.command("stop", axes)
    except BoardError as error:
        return error
    return None


def _known_still(board: Device, axes: list[int]) -> bool:
    """Whether a board says that none of some axes moves or is about to; False if it is silent."""
    try:
        with board.once():
            return not any(state in regs.MOVING_STATES for state in states(board, axes).values())
    except BoardError:
        return False


def _stopping(board: Device, axes: list[int]) -> set[int]:
    """Return those of some axes whose timer still holds the period that a stop has cut short."""
    status = board.input("status")
    return {axis for axis in axes if status >> (regs.STATUS_STOPPING + axis) & 1}


def require(lines: LinesOfBoard, wanted: tuple[str, ...], text: str) -> None:
    """Raise BoardError for the first axis in another state, with the board's fault if any."""
    for axis, state in states(lines.board, lines.axes).items():
        if state not in wanted:
            raise_fault(lines.board)
            lines.board.require_no_reset(axis)
            raise BoardError(f"board {lines.board.unit}: axis {axis} is {state}: {text}")
        if state == "loaded":  # a fault stopped it before its start
            raise_fault(lines.board)


def raise_fault(board: Device) -> None:
    """Raise the board's fault, if it has one."""
    name, text = board.fault()
    if text:
        raise FaultError(f"board {board.unit}: {text}", name)


def _why_not(board: Device, name: str, axes: list[int]) -> BoardError:
    """Return what speaks against a command at present."""
    state = board.inputs()
    said = f"board {board.unit}: {name}:"
    if regs.flags(state["status"])["estop"]:
        return EmergencyStoppedError(f"{said} {EmergencyStoppedError.ADVICE}")
    fault = board.fault_advice()
    if fault and name != "clear_fault":
        return BoardError(f"{said} {fault}")
    return NotPossibleError(f"{said} {_not_now(board, name, axes, state)}")


def _gate_too_near(board: Device) -> str:
    """Return that line zero is too near a burst's first edge; "" if it is not."""
    known = settings.read(board)
    clock_hz, locked = values.hz_of(known), settings.locks(known)
    least = boards.least_gate_edges(clock_hz, board.tick_hz(), locked=locked)
    edges = settings.gate_of(known)
    if not (0 < edges < least and board.has(boards.GATE_FEATURE)):
        return ""
    return boards.gate_text(edges, clock_hz, least, locked=locked)


def _not_now(board: Device, name: str, axes: list[int], state: Mapping[str, int]) -> str:
    """Return which state of a board without a fault speaks against a command."""
    if name == "arm" and snapshot.is_awaited(board, state):
        return (
            f"lines are locked to the pixel clock (setting sync), which is not measured yet: "
            f"{snapshot.clock_beside(board)}"
        )
    if name == "arm" and (found := _gate_too_near(board)):
        return found
    for axis in range(state["axis_count"]) if name == "arm" else ():
        error = regs.code_name(regs.line_errors(), board.axis(axis)["line_error"])
        if error == _TOGETHER:
            return f"axis {axis}: {error}: `pixstep limits --axes N` says how fast N axes can be"
    named = ", ".join(f"axis {axis} is {item}" for axis, item in states(board, axes).items())
    return f"not possible now: {named}"
