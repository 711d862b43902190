# SPDX-License-Identifier: MIT
"""The first look at a wired board, check by check, with a person where one is needed.

Checks that need nobody only look. What asks a person says so first and can be left out; nothing
moves and no output is switched unless the person has agreed.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Protocol

from pixstep.board import boards, meanings, run, settings
from pixstep.board import registers as regs
from pixstep.board.client import Board, BoardError, NoReplyError, Upload
from pixstep.board.device import Identity
from pixstep.board.world import World
from pixstep.lines.line import PLAIN, Line
from pixstep.lines.runs import queue_entries

OK, FAILED, SKIPPED = "ok", "failed", "skipped"
_SWITCHES = ("HOME", "LIMIT_MINUS", "LIMIT_PLUS")  # bits 0, 1, 2 of an axis in `inputs`
_CLOCK_S = 1.0
_CLOCK_SHARE = 0.02  # what a quartz and the way of the requests may be off
_POLL_S = 0.02
_STEPS_HZ = 100  # of the slow move
_BROWN_OUT, _WATCHDOG = 1 << 2, 1 << 3
_ESTOP_BIT, _PERMIT_BIT = 4, 8


class Person(Protocol):
    """Someone at the machine."""

    def agrees(self, question: str) -> bool:
        """Ask for yes or no."""

    def says(self, text: str) -> None:
        """Tell what to do now."""


@dataclass(frozen=True)
class Result:
    """One check: its name, how it ended, what was seen."""

    name: str
    verdict: str
    text: str

    def as_json(self) -> dict:
        """Return plain data."""
        return dict(vars(self))


@dataclass
class SelfTest:
    """The checks of one board; `person` None does only those that need nobody."""

    board: Board
    who: Identity
    world: World
    person: Person | None
    axes: list[int]
    limit_s: float = 30.0
    steps: int = 200
    results: list[Result] = field(default_factory=list)

    def go(self, tell: Callable[[Result], None] = lambda _: None) -> list[Result]:
        """Make all checks, each told as it ends; raises BoardError if the board is not at rest."""
        if self._status() & 0b110:
            raise BoardError(
                f"board {self.board.unit}: an axis is armed or moves: stop it first "
                f"(`pixstep board stop`)"
            )
        for name, check in self._checks():
            try:
                result = check()
            except NoReplyError:
                raise
            except BoardError as error:
                result = Result(name, FAILED, str(error))
            self.results.append(result)
            tell(result)
        return self.results

    @property
    def passed(self) -> bool:
        """True if nothing failed."""
        return all(result.verdict != FAILED for result in self.results)

    def _checks(self) -> Iterator[tuple[str, Callable[[], Result]]]:
        """Yield the checks by name."""
        for name in ("identity", "supply", "fault", "clock"):
            yield name, getattr(self, name)
        for axis in self.axes:
            for bit, signal in enumerate(_SWITCHES):
                yield f"axis {axis} {signal}", partial(self.switch, axis, bit, signal)
        for axis in self.axes:
            yield f"axis {axis} ENABLE", partial(self.driver, axis)
            yield f"axis {axis} STEP, DIR", partial(self.motor, axis)
        yield "PERMIT", self.permit
        yield "ESTOP", self.estop

    def identity(self) -> Result:
        """Which board it is."""
        text = self.board.identify().text
        known = self.who.board in regs.BOARD_IDS.values()
        return Result("identity", OK if known else FAILED, f"{text}, {self.who.axis_count} axes")

    def supply(self) -> Result:
        """What reset the board last: a low supply and a hung program are found by it."""
        cause = self.board.input("reset_cause")
        words = meanings.words(self.board.map.input("reset_cause"), cause)
        if cause & _BROWN_OUT:
            return Result("supply", FAILED, f"last reset: {words}; the 5 V supply breaks down")
        if cause & _WATCHDOG:
            return Result("supply", FAILED, f"last reset: {words}; the firmware hung")
        return Result("supply", OK, f"last reset: {words}")

    def fault(self) -> Result:
        """Whether a fault is latched from before."""
        text = self.board.fault_text()
        if not text:
            return Result("fault", OK, "none latched")
        if self.person is None or not self.person.agrees(f"Latched: {text}. Clear it?"):
            return Result("fault", FAILED, f"{text} Then `pixstep board clear`.")
        run.command(self.board, "clear_fault", [0])
        return Result("fault", OK, f"cleared: {text}")

    def clock(self) -> Result:
        """Whether pixel clock edges come, and as fast as the board is set to."""
        wanted = settings.pixel_hz(self.board)
        least_s = float(max(Fraction(_CLOCK_S), 4 / wanted))
        first, began = self.board.input("pixel_edges"), self.world.now_s()
        self.world.wait(least_s)
        last, ended = self.board.input("pixel_edges"), self.world.now_s()
        edges = (last - first) % (1 << 32)
        pin = self._pin("PIXEL_CLOCK")
        if not edges:
            return Result("pixel clock", FAILED, f"no edge on {pin} in {ended - began:.1f} s")
        hz = edges / (ended - began)
        text = f"{edges} edges in {ended - began:.2f} s, {hz:.2f} Hz; set to {float(wanted):g} Hz"
        slack = _CLOCK_SHARE * float(wanted) + 1.5 / (ended - began)
        return Result("pixel clock", OK if abs(hz - wanted) <= slack else FAILED, text)

    def switch(self, axis: int, bit: int, signal: str) -> Result:
        """Whether a switch changes its own input and no other when it is worked."""
        name, pin = f"axis {axis} {signal}", self._pin(signal, axis)
        if not self._agreed(f"Is {signal} of axis {axis} ({pin}) wired?"):
            return Result(name, SKIPPED, "not wired" if self.person else "needs a person")
        mine = 4 * axis + bit
        before = self.board.input("inputs")
        self._say(
            f"Work the {signal} switch of axis {axis} and let it go, within {self.limit_s:g} s."
        )
        changed = self._changed_input(before, mine)
        if changed is None:
            return Result(name, FAILED, f"{pin} did not change in {self.limit_s:g} s")
        if changed != mine:
            return Result(name, FAILED, f"{self._input_name(changed)} changed instead of {pin}")
        if not self._until(lambda: self.board.input("inputs") == before):
            return Result(name, FAILED, f"{pin} did not change back in {self.limit_s:g} s")
        if before >> mine & 1 and signal != "HOME":
            text = f"{pin} seen, but it is tripped when let go: setting inputs_inverted?"
            return Result(name, FAILED, text)
        return Result(name, OK, f"{pin} seen")

    def driver(self, axis: int) -> Result:
        """Whether the driver comes on."""
        name, pin = f"axis {axis} ENABLE", self._pin("ENABLE", axis)
        if not self._agreed(f"Switch the driver of axis {axis} on ({pin} goes low)?"):
            return Result(name, SKIPPED, "not wanted" if self.person else "needs a person")
        run.command(self.board, "enable", [axis])
        if not self.board.input("outputs") >> axis & 1:
            return Result(name, FAILED, "the board does not say that it is on")
        if not self._agreed(
            f"Does the motor of axis {axis} hold (the shaft does not turn by hand)?"
        ):
            return Result(name, FAILED, f"the motor does not hold: {pin}, motor current, supply")
        return Result(name, OK, f"{pin} on, the motor holds")

    def motor(self, axis: int) -> Result:
        """A few slow steps one way and back, and what the motor did."""
        name = f"axis {axis} STEP, DIR"
        question = f"Turn the motor of axis {axis} {self.steps} slow steps and back?"
        if not self._agreed(question):
            return Result(name, SKIPPED, "not wanted" if self.person else "needs a person")
        for sign, question in (
            (1, "Did it turn?"),
            (-1, "Did it turn back, the other way?"),
        ):
            moved = self._move(axis, sign * self.steps)
            if moved != sign * self.steps:
                return Result(name, FAILED, f"the board counts {moved} steps, not {self.steps}")
            if not self._agreed(question):
                pin = self._pin("STEP" if sign > 0 else "DIR", axis)
                return Result(name, FAILED, f"the motor did not follow: look at {pin}")
        return Result(name, OK, f"{self.steps} steps and back")

    def permit(self) -> Result:
        """Whether the permit output follows."""
        pin = self._pin("PERMIT")
        if not self._agreed(f"Switch the permit output ({pin}, laser or spindle gate) on?"):
            return Result("PERMIT", SKIPPED, "not wanted" if self.person else "needs a person")
        run.command(self.board, "permit_on", [0])
        try:
            seen = self.board.input("outputs") >> _PERMIT_BIT & 1
            agreed = self._agreed(f"Is {pin} high now, and what it permits on?")
        finally:
            run.command(self.board, "permit_off", [0])
        off = not self.board.input("outputs") >> _PERMIT_BIT & 1
        if not (seen and off):
            return Result("PERMIT", FAILED, "the board does not say that it switches")
        return Result("PERMIT", OK if agreed else FAILED, f"{pin} on and off again")

    def estop(self) -> Result:
        """Whether the emergency stop latches, holds while pressed, and clears afterwards."""
        pin = self._pin("ESTOP")
        if not self._agreed(f"Is the emergency stop ({pin}) wired?"):
            return Result("ESTOP", SKIPPED, "not wired" if self.person else "needs a person")
        self._say(f"Press the emergency stop and hold it, within {self.limit_s:g} s.")
        if not self._until(self._pressed):
            return Result("ESTOP", FAILED, f"{pin} did not trip in {self.limit_s:g} s")
        if self.board.fault_name() != "estop":
            return Result("ESTOP", FAILED, "pressed, but no fault estop is latched")
        if self._clears():
            return Result("ESTOP", FAILED, "the fault cleared while it was pressed")
        self._say(f"Release it, within {self.limit_s:g} s.")
        if not self._until(lambda: not self._pressed()):
            return Result("ESTOP", FAILED, f"{pin} stayed tripped for {self.limit_s:g} s")
        if self.board.fault_name() != "estop":
            return Result("ESTOP", FAILED, "the fault went away without a clear")
        if not self._clears():
            return Result("ESTOP", FAILED, "released, but the fault does not clear")
        return Result("ESTOP", OK, f"{pin} latches, holds while pressed, clears when released")

    def _clears(self) -> bool:
        """Try to clear the fault; return whether it is gone."""
        try:
            self.board.command("clear_fault", [0])
        except BoardError:
            return False
        return not self.board.fault_name()

    def _pressed(self) -> bool:
        return bool(self._status() >> _ESTOP_BIT & 1)

    def _status(self) -> int:
        return self.board.input("status")

    def _agreed(self, question: str) -> bool:
        return self.person is not None and self.person.agrees(question)

    def _say(self, text: str) -> None:
        if self.person:
            self.person.says(text)

    def _until(self, done: Callable[[], bool]) -> bool:
        """Wait until something holds; False if it does not in time."""
        end = self.world.now_s() + self.limit_s
        while not done():
            if self.world.now_s() > end:
                return False
            self.world.wait(_POLL_S)
        return True

    def _changed_input(self, before: int, wanted: int) -> int | None:
        """Return the input that changes: `wanted` if it is among them, None if none does."""
        seen: list[int] = []

        def changed() -> bool:
            different = before ^ self.board.input("inputs")
            seen.extend(bit for bit in range(16) if different >> bit & 1)
            return bool(seen)

        if not self._until(changed):
            return None
        return wanted if wanted in seen else seen[0]

    def _move(self, axis: int, steps: int) -> int:
        """Move slowly without the pixel clock; return the steps that the board counts."""
        hz = settings.pixel_hz(self.board)
        per_pixel = max(1, int(_STEPS_HZ / hz))
        whole, rest = divmod(abs(steps), per_pixel)
        sign = 1 if steps > 0 else -1
        counts = [sign * per_pixel] * whole + ([sign * rest] if rest else [])
        before = run.positions(self.board, [axis])[axis]
        line = Line(tuple(counts), PLAIN, clocked=False, name="self-test")
        upload = Upload(self.board, axis, queue_entries(line))
        upload.push()
        run.arm(self.board, [axis])
        run.follow([run.Lines(self.board, [axis], [upload])], self.world)
        return run.positions(self.board, [axis])[axis] - before

    def _pin(self, signal: str, axis: int = 0) -> str:
        """Return a signal's pin on the board's header, with its name."""
        for pin in boards.load(self.who.board).pins:
            if (pin.signal, pin.axis) == (signal, axis):
                return f"{signal} on {pin.header}"
        return signal

    def _input_name(self, bit: int) -> str:
        axis, which = divmod(bit, 4)
        if which < len(_SWITCHES):
            return f"{self._pin(_SWITCHES[which], axis)} (axis {axis})"
        return f"input bit {bit}"
