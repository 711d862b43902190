# SPDX-License-Identifier: MIT
"""A board beside a person: asking, waiting for inputs, moving slowly, the names of pins."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from pixstep.board import boards, orders, run, settings
from pixstep.board import registers as regs
from pixstep.board.device import Board, Identity
from pixstep.board.errors import BoardError
from pixstep.board.link import World
from pixstep.board.upload import Upload, require_idle
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries

SWITCHES = ("HOME", "LIMIT_MINUS", "LIMIT_PLUS")  # bits 0, 1, 2 of an axis in `inputs`
_POLL_S = 0.02
_STEPS_HZ = 100  # of the slow move


class Person(Protocol):
    """Someone at the machine."""

    def agrees(self, question: str, *, default: bool = True) -> bool:
        """Ask for yes or no; `default` is what a bare Enter means."""

    def says(self, text: str) -> None:
        """Tell what to do now."""


@dataclass
class AtMachine:
    """What the checks of a self-test are made of; `person` None is nobody there."""

    board: Board
    who: Identity
    world: World
    person: Person | None
    axes: list[int]
    limit_s: float = 30.0
    steps: int = 200

    def clears(self) -> bool:
        """Try to clear the fault; return whether it is gone."""
        try:
            orders.clear_fault(self.board)
        except BoardError:
            return False
        return not self.board.fault_name()

    def pressed(self) -> bool:
        return self.flags()["estop"]

    def flags(self) -> dict[str, bool]:
        return regs.flags(self.board.input("status"))

    def agreed(self, question: str, *, default: bool = True) -> bool:
        return self.person is not None and self.person.agrees(question, default=default)

    def tell(self, text: str) -> None:
        if self.person:
            self.person.says(text)

    def wait_until(self, done: Callable[[], bool]) -> bool:
        """Wait until something holds; False if it does not in time."""
        end = self.world.now_s() + self.limit_s
        while not done():
            if self.world.now_s() > end:
                return False
            self.world.wait(_POLL_S)
        return True

    def changed_input(self, before: int, wanted: int) -> int | None:
        """Return the input that changes: `wanted` if it is among them, None if none does."""
        seen: list[int] = []

        def changed() -> bool:
            different = before ^ self.board.input("inputs")
            seen.extend(bit for bit in range(16) if different >> bit & 1)
            return bool(seen)

        if not self.wait_until(changed):
            return None
        return wanted if wanted in seen else seen[0]

    def move_slowly(self, axis: int, steps: int) -> int:
        """Move slowly without the pixel clock; return the steps that the board counts.

        Ctrl-C stops the axis.
        """
        hz = settings.pixel_hz(self.board)
        per_pixel = max(1, int(_STEPS_HZ / hz))
        whole, rest = divmod(abs(steps), per_pixel)
        sign = 1 if steps > 0 else -1
        counts = [sign * per_pixel] * whole + ([sign * rest] if rest else [])
        before = run.positions(self.board, [axis])[axis]
        line = Line(tuple(counts), PLAIN, clocked=False, name="self-test")
        require_idle(self.board, [axis])
        upload = Upload(self.board, axis, queue_entries(line))
        group = [run.Lines(self.board, [axis], [upload])]
        try:
            upload.push()
            run.arm_queued(group[0])
            run.follow(group, self.world)
        except KeyboardInterrupt:
            run.stop(group)
            raise
        return run.positions(self.board, [axis])[axis] - before

    def pin(self, signal: str, axis: int = 0) -> str:
        """Return a signal's pin on the board's header, with its name."""
        for pin in boards.load(self.who.board).pins:
            if (pin.signal, pin.axis) == (signal, axis):
                return f"{signal} on {pin.header}"
        return signal

    def input_name(self, bit: int) -> str:
        axis, which = divmod(bit, 4)
        if which < len(SWITCHES):
            return f"{self.pin(SWITCHES[which], axis)} (axis {axis})"
        return f"input bit {bit}"
