# SPDX-License-Identifier: MIT
"""The first look at a wired board, check by check, with a person where one is needed.

Checks that need nobody only look. What asks a person says so first and can be left out; nothing
moves and no output is switched unless the person has agreed.
"""

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import Protocol

from pixstep.board import boards, orders, run, settings, snapshot
from pixstep.board import registers as regs
from pixstep.board.device import Device, Identity
from pixstep.board.errors import BoardError, LineLostError, NoReplyError
from pixstep.board.link import World
from pixstep.board.upload import LineUpload, require_idle
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

    board: Device
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
        upload = LineUpload(self.board, axis, queue_entries(line))
        group = [run.LinesOfBoard(self.board, [axis], [upload])]
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


OK, FAILED, SKIPPED = "ok", "failed", "skipped"
_CLOCK_S = 1.0
_CLOCK_SHARE = 0.02  # what a quartz and the way of the requests may be off
_BROWN_OUT, _WATCHDOG = 1 << 2, 1 << 3


@dataclass(frozen=True)
class SelftestResult:
    """One check: its name, how it ended, what was seen."""

    name: str
    verdict: str
    text: str

    def as_json(self) -> dict[str, object]:
        """Return plain data."""
        return dict(vars(self))


def _clock_result(text: str, *, right: bool) -> SelftestResult:
    return SelftestResult("pixel clock", OK if right else FAILED, text)


_NO_CLOCK = SelftestResult("pixel clock", SKIPPED, "not wired: run lines with --sync free")


def _watch_s(hz: Fraction) -> float:
    """Return for how long edges of a clock are counted."""
    return float(max(Fraction(_CLOCK_S), 4 / hz))


@dataclass
class SelfTest(AtMachine):
    """The checks of one board; without a person only those that need nobody."""

    results: list[SelftestResult] = field(default_factory=list)

    def go(self, tell: Callable[[SelftestResult], None] = lambda _: None) -> list[SelftestResult]:
        """Make all checks, each told as it ends; raises BoardError if the board is not at rest.

        Drivers that it has switched on are off again at its end, however that comes.
        """
        flags = self.flags()
        if flags["armed"] or flags["running"]:
            raise BoardError(
                f"board {self.board.unit}: an axis is armed or moves: stop it first "
                f"(`pixstep board stop`)"
            )
        were_on = self._drivers_on()
        try:
            for name, check in self._checks():
                self.results.append(_result(name, check))
                tell(self.results[-1])
        finally:
            with contextlib.suppress(BoardError):
                switched = self._drivers_on() - were_on
                if switched:
                    self.board.command("disable", sorted(switched))
        return self.results

    @property
    def passed(self) -> bool:
        """True if nothing failed."""
        return all(result.verdict != FAILED for result in self.results)

    def _drivers_on(self) -> set[int]:
        """Return the axes whose drivers are on."""
        outputs = self.board.input("outputs")
        return {axis for axis in self.axes if outputs >> axis & 1}

    def _checks(self) -> Iterator[tuple[str, Callable[[], SelftestResult]]]:
        """Yield the checks by name."""
        for name in ("identity", "supply", "fault", "clock"):
            yield name, getattr(self, name)
        for axis in self.axes:
            for bit, signal in enumerate(SWITCHES):
                yield f"axis {axis} {signal}", partial(self.switch, axis, bit, signal)
        for axis in self.axes:
            yield f"axis {axis} ENABLE", partial(self.driver, axis)
            yield f"axis {axis} STEP, DIR", partial(self.motor, axis)
        yield "PERMIT", self.permit
        yield "ESTOP", self.estop

    def identity(self) -> SelftestResult:
        """Which board it is."""
        text = f"pixstep {self.who.board} {self.who.firmware}"
        known = self.who.board in regs.BOARD_IDS.values()
        return SelftestResult(
            "identity", OK if known else FAILED, f"{text}, {self.who.axis_count} axes"
        )

    def supply(self) -> SelftestResult:
        """What reset the board last: a low supply and a hung program are found by it."""
        cause = self.board.input("reset_cause")
        words = regs.words(self.board.map.input("reset_cause"), cause)
        if cause & _BROWN_OUT:
            return SelftestResult(
                "supply", FAILED, f"last reset: {words}; the 5 V supply breaks down"
            )
        if cause & _WATCHDOG:
            return SelftestResult("supply", FAILED, f"last reset: {words}; the firmware hung")
        return SelftestResult("supply", OK, f"last reset: {words}")

    def fault(self) -> SelftestResult:
        """Whether a fault is latched from before."""
        text = self.board.fault_text()
        if not text:
            return SelftestResult("fault", OK, "none latched")
        if self.person is None or not self.person.agrees(f"Latched: {text}. Clear it?"):
            return SelftestResult("fault", FAILED, self.board.fault_advice())
        run.command(self.board, "clear_fault", [0])
        return SelftestResult("fault", OK, f"cleared: {text}")

    def clock(self) -> SelftestResult:
        """Whether pixel clock edges come, and as fast as the board is set to.

        Where none comes the board can make them itself, if a wire takes them to the input.
        """
        if self.board.has(boards.CLOCK_OUT_FEATURE):
            own = self.board.setting(boards.CLOCK_OUT_SETTING)
            if own:
                return self._own_clock(own)
        wanted = self.board.clock_hz()
        edges, seconds = self._count_edges(wanted)
        if not edges:
            return self._no_clock(wanted, seconds)
        text = f"{edges} edges in {seconds:.2f} s, {edges / seconds:.2f} Hz"
        right = self._is_right(edges, seconds, wanted)
        return _clock_result(f"{text}; set to {float(wanted):g} Hz", right=right)

    def _count_edges(self, wanted: Fraction) -> tuple[int, float]:
        """Return how many edges of a clock of about so many hertz come, and in which time."""
        first, began = self.board.input("pixel_edges"), self.world.now_s()
        self.world.wait(_watch_s(wanted))
        last, ended = self.board.input("pixel_edges"), self.world.now_s()
        return (last - first) % (1 << 32), ended - began

    def _is_right(self, edges: int, seconds: float, wanted: Fraction) -> bool:
        slack = _CLOCK_SHARE * float(wanted) + 1.5 / seconds
        return abs(edges / seconds - wanted) <= slack or self._board_times_clock(_watch_s(wanted))

    def _no_clock(self, wanted: Fraction, seconds: float) -> SelftestResult:
        """Let the board make the clock if someone says that it is wired; else tell what to do."""
        text = f"no edge on {self.pin('PIXEL_CLOCK')} in {seconds:.1f} s"
        if not self.board.has(boards.CLOCK_OUT_FEATURE):
            if self._has_no_clock():
                return _NO_CLOCK
            return _clock_result(f"{text}; a line with --sync free needs no clock", right=False)
        hz = min(max(round(wanted), 1), boards.MOST_CLOCK_OUT_HZ)
        out = self.pin("CLOCK_OUT")
        wired = self.agreed(f"No pixel clock comes. Does a wire join {out} and {self._input()}?")
        if not wired:
            if self._has_no_clock():
                return _NO_CLOCK
            make = f"`pixstep board set {boards.CLOCK_OUT_SETTING}={hz}`"
            return _clock_result(f"{text}; {make} makes a clock on {out}", right=False)
        self.board.write_setting(boards.CLOCK_OUT_SETTING, hz)
        try:
            return self._own_clock(hz)
        finally:
            self.board.write_setting(boards.CLOCK_OUT_SETTING, 0)

    def _has_no_clock(self) -> bool:
        """Whether someone says that no pixel clock is wired."""
        if self.person is None:
            return False
        return not self.person.agrees(f"Is a pixel clock wired to {self._input()}?")

    def _own_clock(self, asked_hz: int) -> SelftestResult:
        """Whether the clock that the board makes comes in again, and is what the lines expect."""
        made = boards.clock_out_hz(asked_hz, self.board.tick_hz())
        edges, seconds = self._count_edges(made)
        if not edges:
            wire = f"is {self.pin('CLOCK_OUT')} wired to {self._input()}?"
            text = f"no edge on the clock input in {seconds:.1f} s: {wire}"
            return _clock_result(text, right=False)
        text = (
            f"the board's own on {self.pin('CLOCK_OUT')}: measured {edges / seconds:.2f} Hz, "
            f"set {float(made):.6g} Hz"
        )
        wanted = self.board.clock_hz()
        if abs(made - wanted) > _CLOCK_SHARE * wanted:
            return _clock_result(f"{text}; but pixel_hz is {float(wanted):g} Hz", right=False)
        return _clock_result(text, right=self._is_right(edges, seconds, made))

    def _input(self) -> str:
        """Return the pins that take the pixel clock; some boards have two."""
        pins = boards.load(self.who.board).pins
        found = [pin.header for pin in pins if pin.signal.startswith("PIXEL_CLOCK")]
        return f"PIXEL_CLOCK on {' and '.join(found)}"

    def _board_times_clock(self, wait_s: float) -> bool:
        """Whether the clock is right by the board's own time, each edge in its place.

        The host's time is no measure where the host waits for the processor, or where a simulated
        board is slower than real time.
        """
        before = snapshot.read_clock(self.board, self.board.inputs())
        self.world.wait(wait_s)
        after = snapshot.read_clock(self.board, self.board.inputs())
        if before is None or after is None:
            return False
        in_place = (before.missing, before.false) == (after.missing, after.false)
        return in_place and abs(after.offset_ppm) <= 1e6 * _CLOCK_SHARE

    def switch(self, axis: int, bit: int, signal: str) -> SelftestResult:
        """Whether a switch changes its own input and no other when it is worked."""
        name, pin = f"axis {axis} {signal}", self.pin(signal, axis)
        if not self.agreed(f"Is {signal} of axis {axis} ({pin}) wired?"):
            return SelftestResult(name, SKIPPED, "not wired" if self.person else "needs a person")
        mine = 4 * axis + bit
        before = self.board.input("inputs")
        self.tell(
            f"Work the {signal} switch of axis {axis} and let it go, within {self.limit_s:g} s."
        )
        changed = self.changed_input(before, mine)
        if changed is None:
            return SelftestResult(name, FAILED, f"{pin} did not change in {self.limit_s:g} s")
        if changed != mine:
            return SelftestResult(
                name, FAILED, f"{self.input_name(changed)} changed instead of {pin}"
            )
        if not self.wait_until(lambda: self.board.input("inputs") == before):
            return SelftestResult(name, FAILED, f"{pin} did not change back in {self.limit_s:g} s")
        if before >> mine & 1 and signal != "HOME":
            text = f"{pin} seen, but it is tripped when let go: setting inputs_inverted?"
            return SelftestResult(name, FAILED, text)
        return SelftestResult(name, OK, f"{pin} seen")

    def driver(self, axis: int) -> SelftestResult:
        """Whether the driver comes on."""
        name, pin = f"axis {axis} ENABLE", self.pin("ENABLE", axis)
        if not self.agreed(f"Switch the driver of axis {axis} on ({pin} goes low)?"):
            return SelftestResult(name, SKIPPED, "not wanted" if self.person else "needs a person")
        run.command(self.board, "enable", [axis])
        if axis not in self._drivers_on():
            return SelftestResult(name, FAILED, "the board does not say that it is on")
        if not self.agreed(
            f"Does the motor of axis {axis} hold (the shaft does not turn by hand)?"
        ):
            return SelftestResult(
                name, FAILED, f"the motor does not hold: {pin}, motor current, supply"
            )
        return SelftestResult(name, OK, f"{pin} on, the motor holds")

    def motor(self, axis: int) -> SelftestResult:
        """A few slow steps one way and back, and what the motor did."""
        name = f"axis {axis} STEP, DIR"
        question = f"Turn the motor of axis {axis} {self.steps} slow steps and back?"
        if not self.agreed(question):
            return SelftestResult(name, SKIPPED, "not wanted" if self.person else "needs a person")
        for sign, question in (
            (1, "Did it turn?"),
            (-1, "Did it turn back, the other way?"),
        ):
            moved = self.move_slowly(axis, sign * self.steps)
            if moved != sign * self.steps:
                return SelftestResult(
                    name, FAILED, f"the board counts {moved} steps, not {self.steps}"
                )
            if not self.agreed(question):
                pin = self.pin("STEP" if sign > 0 else "DIR", axis)
                return SelftestResult(name, FAILED, f"the motor did not follow: look at {pin}")
        return SelftestResult(name, OK, f"{self.steps} steps and back")

    def permit(self) -> SelftestResult:
        """Whether the permit output follows."""
        pin = self.pin("PERMIT")
        question = f"Switch the permit output ({pin}, laser or spindle gate) on?"
        if not self.agreed(question, default=False):
            return SelftestResult(
                "PERMIT", SKIPPED, "not wanted" if self.person else "needs a person"
            )
        run.command(self.board, "permit_on", [0])
        try:
            seen = self.board.input("outputs") >> regs.OUTPUT_PERMIT & 1
            agreed = self.agreed(f"Is {pin} high now, and what it permits on?")
        finally:
            run.command(self.board, "permit_off", [0])
        off = not self.board.input("outputs") >> regs.OUTPUT_PERMIT & 1
        if not (seen and off):
            return SelftestResult("PERMIT", FAILED, "the board does not say that it switches")
        return SelftestResult("PERMIT", OK if agreed else FAILED, f"{pin} on and off again")

    def estop(self) -> SelftestResult:
        """Whether the emergency stop latches, holds while pressed, and clears afterwards."""
        pin = self.pin("ESTOP")
        if not self.agreed(f"Is the emergency stop ({pin}) wired?"):
            return SelftestResult(
                "ESTOP", SKIPPED, "not wired" if self.person else "needs a person"
            )
        self.tell(f"Press the emergency stop and hold it, within {self.limit_s:g} s.")
        if not self.wait_until(self.pressed):
            return SelftestResult("ESTOP", FAILED, f"{pin} did not trip in {self.limit_s:g} s")
        if self.board.fault_name() != "estop":
            return SelftestResult("ESTOP", FAILED, "pressed, but no fault estop is latched")
        if self.clears():
            return SelftestResult("ESTOP", FAILED, "the fault cleared while it was pressed")
        self.tell(f"Release it, within {self.limit_s:g} s.")
        if not self.wait_until(lambda: not self.pressed()):
            return SelftestResult("ESTOP", FAILED, f"{pin} stayed tripped for {self.limit_s:g} s")
        if self.board.fault_name() != "estop":
            return SelftestResult("ESTOP", FAILED, "the fault went away without a clear")
        if not self.clears():
            return SelftestResult("ESTOP", FAILED, "released, but the fault does not clear")
        return SelftestResult(
            "ESTOP", OK, f"{pin} latches, holds while pressed, clears when released"
        )


def _result(name: str, check: Callable[[], SelftestResult]) -> SelftestResult:
    """Return the result of a check; a board that refuses has failed, a silent one ends the test."""
    try:
        return check()
    except (NoReplyError, LineLostError):
        raise
    except BoardError as error:
        return SelftestResult(name, FAILED, str(error))
