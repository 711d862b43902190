# SPDX-License-Identifier: MIT
"""What each command does in each state of an axis, tried on the simulated board: a generated table.

Every cell is one trial of the real image: an axis is brought into the state, the permit output is
switched on where that is possible, the command is sent, and what is told of it is what the board's
reply, registers and pins then said.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction

from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.board.errors import BoardError
from pixstep.board.upload import LineUpload
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries
from pixstep.progress import Progress, unseen
from pixstep.simulation.simulated_board import SimulatedBoard
from pixstep_dev.markdown import table
from pixstep_trials.probe import BoardProbe
from pixstep_trials.wire import seal

BOARD = "mega"
AXIS = 1
HZ = Fraction(18)
STEPS_PX = 14  # a period of 63,492 ticks: the timer holds one for 4 ms
_MS = boards.load(BOARD).tick_hz // 1000
_LONGEST_PERIOD_CYCLES = 0x10000
_HALTING = 3  # enum step_engine_state
_ESTOP = "emergency stop"
_AXIS_COMMANDS = ("arm", "disarm", "stop", "discard", "enable", "disable", "zero")
ROWS = (*_AXIS_COMMANDS, "permit_on", "permit_off", "go", "clear_fault", _ESTOP)


@dataclass(frozen=True)
class Cell:
    """What one command did in one state."""

    accepted: bool
    state: str  # of the axis, when all is at rest
    changed: bool
    permit_dropped: bool
    moves: bool  # STEP edges follow for longer than the period that the timer holds

    def text(self, row: str) -> str:
        """Return the words of the table."""
        if not self.accepted:
            return "refused"
        parts = [f"**{self.state}**" if self.changed else "-"]
        if self.permit_dropped and row != "permit_off":
            parts.append("permit off")
        return ", ".join(parts)


class _CommandTrial:
    """One board with axis 1 in one state."""

    def __init__(self, run: SimulatedBoard) -> None:
        self.sim, self.board = run.simulator, run.board
        self.board.set_pixel_hz(HZ)
        self.board.write_setting("bus_timeout_ms", 0)

    def state(self) -> str:
        return regs.AXIS_STATES[self.board.axis(AXIS)["axis_state"]]

    def load(self, pixels: int = 200) -> None:
        LineUpload(self.board, AXIS, queue_entries(Line((STEPS_PX,) * pixels, PLAIN))).push()

    def block(self, *entries: tuple[int, int]) -> None:
        number = self.board.axis(AXIS)["next_block"]
        words = [number, AXIS, *(word & 0xFFFF for entry in entries for word in entry)]
        self.board.write(regs.QUEUE_WINDOW, words)

    def until(self, done: Callable[[], bool], what: str) -> None:
        for _ in range(4000):
            if done():
                return
            self.sim.run(_MS // 4)
        raise UserError(f"commands: the simulated board never got to {what}")

    def arm(self, pixels: int = 200) -> None:
        self.load(pixels)
        self.board.command("arm", [AXIS])

    def run(self) -> None:
        self.arm()
        self.until(lambda: self.sim.count(0, AXIS) >= 3, "running")

    # Each brings the axis into the state of its name.

    def empty(self) -> None:
        """Nothing to do."""

    def loading(self) -> None:
        self.block((0x0021, 0), (0, 0))

    def loaded(self) -> None:
        self.load()

    def armed(self) -> None:
        self.arm()

    def running(self) -> None:
        self.run()

    def stopping(self) -> None:
        """Stop it early in a period: what follows comes before that period is over.

        edge k          edge k + 1                       edge k + 2, the last one
        |------- 4 ms -------|-----------------------------|
               |-- stop --|    |-- command, silence --|
        """
        self.run()
        made = self.sim.count(0, AXIS)
        self.until(lambda: self.sim.count(0, AXIS) > made, "a step")
        self.sim.run(28 * _MS // 10)
        self.sim.command(f"send {_request(0, 'stop').hex()} 0")
        for _ in range(100):
            if self.halting():
                return
            self.sim.run(_MS // 20)
        raise UserError("commands: the simulated board did not stop")

    def halting(self) -> bool:
        """True while the timer still holds a period that pulses."""
        size = BoardProbe(self.sim).symbol(0, "step_engines").size // boards.load(BOARD).axes
        return BoardProbe(self.sim).peek(0, f"step_engines+{AXIS * size + 1}", 1)[0] == _HALTING

    def done(self) -> None:
        self.arm(pixels=2)
        self.until(lambda: self.state() == "done", "the line's end")

    def refused(self) -> None:
        try:
            self.block((2, 0))
        except BoardError:
            return

    def fault(self) -> None:
        self.run()
        self.press(0)
        self.sim.run(10 * _MS)
        self.press(1)

    def press(self, level: int) -> None:
        (pin,) = [pin for pin in boards.load(BOARD).pins if pin.signal == "ESTOP"]
        self.sim.pin(0, pin.port, pin.bit, level)


STATES = (
    "empty", "loading", "loaded", "armed", "running", "stopping", "done", "refused", "fault",
)  # fmt: skip


def _request(unit: int, name: str) -> bytes:
    mask = 1 << AXIS if name in _AXIS_COMMANDS else 0
    return seal(bytes([unit, 16, 1, 0, 0, 2, 4, 0, mask, 0, regs.COMMANDS[name]]))


@contextmanager
def _trial(state: str) -> Iterator[_CommandTrial]:
    with SimulatedBoard(BOARD, HZ) as run:
        trial = _CommandTrial(run)
        if state != "fault":
            trial.board.permit(True)
        getattr(trial, state)()
        yield trial


def _give(trial: _CommandTrial, row: str) -> bool:
    """Give a command or press the stop; return whether it was accepted."""
    if row == _ESTOP:
        trial.press(0)
        return True
    reply = trial.sim.transmit(_request(1, row))
    if len(reply) < 2:
        raise UserError(f"commands: no reply to {row}")
    return not reply[1] & 0x80


def _try(state: str, row: str) -> Cell:
    with _trial(state) as trial:
        # A look at the registers takes longer than an axis is stopping.
        before = "empty" if state == "stopping" else trial.state()
        permit = trial.sim.permit(0).level
        accepted = _give(trial, row)
        trial.sim.run(2 * _LONGEST_PERIOD_CYCLES)
        made = trial.sim.count(0, AXIS)
        after = trial.state()
        trial.sim.wait_s(0.25)
        moves = trial.sim.count(0, AXIS) != made
        if not moves and trial.board.axis(AXIS)["position_steps"] != trial.sim.steps(0, AXIS):
            raise UserError(f"commands: {row} in {state}: the position is not the steps made")
        dropped = permit == 1 and trial.sim.permit(0).level == 0
        return Cell(accepted, after, after != before, dropped, moves)


def cells(progress: Progress = unseen) -> dict[tuple[str, str], Cell]:
    """Try every command in every state."""
    pairs = [(row, state) for row in ROWS for state in STATES]
    found = {}
    for row, state in pairs:
        found[row, state] = _try(state, row)
        progress(len(found) / len(pairs))
    return found


def commands(progress: Progress = unseen) -> str:
    """Return the table as Markdown."""
    found = cells(progress)
    rows = [
        (
            f"`{row}`" if row in regs.COMMANDS else row,
            *(found[row, state].text(row) for state in STATES),
        )
        for row in ROWS
    ]
    return table(("command", *STATES), rows)
