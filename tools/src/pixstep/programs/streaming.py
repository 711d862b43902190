# SPDX-License-Identifier: MIT
"""A program on a board: rehearsed at rest, then uploaded while it is planned and while it runs.

No length of a program needs memory.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from pixstep.board import capability, settings, snapshot
from pixstep.board import run as running
from pixstep.board.device import Device
from pixstep.board.link import World
from pixstep.board.upload import LineUpload, require_idle, said_divider
from pixstep.errors import PlainError, RefusedError, UserError
from pixstep.lines.units import refuse_period
from pixstep.machine.model import MachineTables
from pixstep.programs import plan_lines
from pixstep.programs.motors import PlanMotor, Setup
from pixstep.programs.plan import Plan, PlanProcess, PlanRequest
from pixstep.programs.plan_lines import Entry, MotorEntries
from pixstep.programs.report import Report
from pixstep.progress import Progress, unseen

_AHEAD = 2048  # entries that wait for the board's queue
_FAR = 20_000  # pixels that are planned ahead of the motor that has taken the fewest


class Entries:
    """The queue entries of every motor's line, from one plan that all of them draw on.

    `ways` are the directions of the motors, if they are known: without them a smooth motor's line
    begins when the plan has come to its first step.
    """

    def __init__(
        self, source: PlanProcess, motors: Sequence[PlanMotor], ways: Sequence[int] = ()
    ) -> None:
        self._source = source
        self._motors = [
            MotorEntries(motor, way)
            for motor, way in zip(motors, ways or [0] * len(motors), strict=True)
        ]

    def say(self, divider: int | None) -> None:
        """Let the lines say how many clock edges a pixel has, before any entry is taken."""
        for motor in self._motors:
            motor.divider = divider

    @property
    def pixels_ahead(self) -> int:
        """Pixels that are planned and wait for the motor that has taken the fewest."""
        return max(one.pixels for one in self._motors)

    def steps(self, index: int) -> int:
        """Return the steps of a motor in all that was planned, there and back."""
        return self._motors[index].steps

    def take(self, index: int, most: int, *, wait: bool) -> list[Entry]:
        """Return entries of a motor, at most so many; with `wait` those that are still planned."""
        motor = self._motors[index]
        while motor.unknown and self._more(wait=True):
            pass
        found: list[Entry] = []
        while len(found) < most:
            found += motor.take(most - len(found), whole=True, over=self._source.over)
            far = self.pixels_ahead >= _FAR
            if far:
                found += motor.take(most - len(found), whole=False, over=self._source.over)
            if far or len(found) >= most or not self._more(wait=wait):
                break
        return found

    def _more(self, *, wait: bool) -> bool:
        """Take some more pixels for all motors; False if there are none, or none yet."""
        over = self._source.over
        part = self._source.more(wait=wait)
        if part is None:
            return self._source.over != over
        for index, motor in enumerate(self._motors):
            motor.add(part[:, index])
        return True


class StreamedUpload(LineUpload):
    """An upload whose entries are made when the board has room for them."""

    def __init__(self, board: Device, axis: int, entries: Entries, index: int) -> None:
        super().__init__(board, axis, [])
        self._entries, self._index = entries, index

    @property
    def done(self) -> bool:
        """True when every entry has been accepted."""
        self._refill()
        return not self._left

    def push(self) -> int:
        """Send blocks until the queue is full or the plan is over; return entries accepted."""
        accepted = 0
        while True:
            self._refill()
            now = super().push()
            accepted += now
            if not now or self._left:
                return accepted

    def _refill(self) -> None:
        """Take what is planned; the planner is waited for only if nothing is left to send."""
        for wanted, wait in ((1, True), (_AHEAD, False)):
            missing = wanted - len(self._left)
            if missing > 0:
                self._add(self._entries.take(self._index, missing, wait=wait))


def prepare(
    board: Device, entries: Entries, motors: Sequence[PlanMotor], divider: int | None = None
) -> running.LinesOfBoard:
    """Return the lines of a plan, nothing of which is queued yet.

    `divider` is how many clock edges a pixel has, if the lines are to say it. Raises UserError for
    motors that share an axis, BoardError for an axis that has a line already.
    """
    axes = [motor.axis for motor in motors]
    if len(set(axes)) < len(axes):
        raise UserError(f"axes {', '.join(map(str, axes))}: a program streams to one board")
    require_idle(board, axes)
    entries.say(said_divider(board, divider))
    uploads = [StreamedUpload(board, axis, entries, index) for index, axis in enumerate(axes)]
    return running.LinesOfBoard(board, axes, list(uploads))


def load(lines: running.LinesOfBoard) -> None:
    """Fill the queues of a board with the beginning of a plan.

    Call it where a signal stops the axes. If the board or the plan ends it, what is queued is
    discarded, and the error raised.
    """
    try:
        for upload in lines.uploads:
            upload.push()
    except PlainError:
        running.discard(lines)
        raise


def follow(
    lines: running.LinesOfBoard, world: World, pixels: int = 0, go: Progress = unseen
) -> None:
    """Stream what is left of a plan that runs, and wait for its end.

    Raises BoardError as a board does. A mistake in the program that shows only now stops all axes;
    it is raised with where they are.
    """
    try:
        running.follow([lines], world, pixels, go)
    except UserError as error:
        told = running.stop([lines])
        raise type(error)(f"{error} (stopped: {told})") from None


@dataclass(frozen=True)
class OnBoard:
    """A program that a board is set up for; `pixels` is its length, 0 if it is not known."""

    board: Device
    setup: Setup
    lines: running.LinesOfBoard
    entries: Entries
    before: dict[int, int]
    pixels: int

    def run(
        self,
        world: World,
        progress: Progress = unseen,
        begun: Callable[[], None] = lambda: None,
    ) -> None:
        """Queue its beginning, arm the motors, which start on one edge, and follow them to the end.

        `begun` is called when they are armed. Call it where a signal stops the axes: a part of a
        line in a queue keeps the next one out. Raises BoardError as a board does, UserError for a
        mistake in the program that shows only now: the motors are stopped then.
        """
        load(self.lines)
        snapshot.await_lock(self.board, world)
        running.arm_queued(self.lines)
        begun()
        follow(self.lines, world, self.pixels, progress)

    def rows(self) -> list[dict[str, object]]:
        """Return what each motor has done as plain data, once all of them are done."""
        axes = self.lines.axes
        states, places = running.states(self.board, axes), running.positions(self.board, axes)
        return [
            {
                "axis": motor.axis,
                "motor": motor.name,
                "state": states[motor.axis],
                "made_steps": self.entries.steps(index),
                "from_steps": self.before[motor.axis],
                "moved_steps": places[motor.axis] - self.before[motor.axis],
                "position_steps": places[motor.axis],
            }
            for index, motor in enumerate(self.setup.motors)
        ]


def require_fitting(machine: MachineTables, setup: Setup, kind: str) -> None:
    """Raise UserError for motors on several boards, RefusedError for a board of another kind."""
    names = {motor.name: machine.board_name(machine.motors[motor.name]) for motor in setup.motors}
    boards = sorted(set(names.values()))
    if len(boards) > 1:
        raise UserError(
            f"{machine.path}: motors on boards {' and '.join(boards)}: a program streams to one "
            f"board"
        )
    wanted = machine.boards[boards[0]].kind
    if wanted != kind:
        raise RefusedError(f"{machine.path} has boards.{boards[0]} as a {wanted}, it is a {kind}")


def rehearse(board: Device, request: PlanRequest, progress: Progress = unseen) -> Report:
    """Plan a program to its end with the board's own limits; nothing is sent.

    Raises UserError for a mistake in the program, RefusedError for what the board would refuse.
    """
    setup = request.setup
    bounds = capability.connected_limits(board, setup.pixel_hz, len(setup.motors), setup.clock)
    with request.text() as text:
        plan = Plan(request.path, text, setup, request.options)
        return plan_lines.rehearse(plan, bounds, progress)


@contextmanager
def prepared(board: Device, request: PlanRequest, known: Report | None = None) -> Iterator[OnBoard]:
    """Set a board up for a program, its rehearsal being `known`; end the planner at the end.

    Sets the board's clock, and how many of its edges are a pixel, to those of the plan. Raises as
    `streaming.prepare` does.
    """
    setup = request.setup
    refuse_period(setup.pixel_hz, board.tick_hz())
    settings.set_clock(
        board, setup.pixel_hz * setup.divider, setup.sync, setup.divider, setup.gate_edges,
        setup.clock_out_hz,
    )  # fmt: skip
    axes = [motor.axis for motor in setup.motors]
    before = dict(running.positions(board, axes))
    with PlanProcess(request) as source:
        entries = Entries(source, setup.motors, known.ways if known else ())
        lines = prepare(board, entries, setup.motors, setup.divider)
        yield OnBoard(board, setup, lines, entries, before, known.pixels if known else 0)
