# SPDX-License-Identifier: MIT
"""What must hold, whatever was commanded: which axes may make edges, where PERMIT may be high.

The model follows only what forbids something. What a broadcast did is unknown until the next
reading of the board; until then nothing is forbidden that it may have allowed.
"""

from dataclasses import dataclass, field

from pixstep.board import registers as regs
from pixstep_dev.robustness.orders import actions
from pixstep_dev.robustness.orders.world import ActionOutcome

HELD_CYCLES = 2 * 65_536  # the period that the timer runs and the one that it holds
# From the pin's edge until the main program has made its last instruction before the stop's
# interrupt: synchroniser, what holds interrupts off, one instruction behind each handler.
ESTOP_ENTRY_CYCLES = 200
# As robustness.estops has it: confirmation, other interrupts, one axis after the other.
ESTOP_CYCLES = 2400
ENDING = frozenset(("stop", "disarm", "discard"))  # an axis that was told so makes no more steps
_COIL_GROUP = 4
_MARK_WAIT, _MARK_SEEK = 0x20, 0x80


@dataclass
class AxisModel:
    """What one axis may do.

    `halted`: the axis makes one more edge at most behind this cycle, none behind HELD_CYCLES more.
    `rest`: number of edges that it has made and that no other may follow; None while some may.
    """

    rest: int | None = 0
    halted: int | None = None
    armed: int | None = None  # edges made when it was armed out of rest

    def halt(self, cycle: int) -> None:
        """The axis has been halted by this cycle at the latest."""
        if self.rest is None and (self.halted is None or cycle < self.halted):
            self.halted = cycle

    def free(self) -> None:
        """The axis may move from now on."""
        self.armed = self.rest
        self.rest = self.halted = None

    def settle(self, count: int) -> None:
        """The axis rests, with so many edges made."""
        self.rest, self.halted, self.armed = count, None, None


@dataclass
class PermitModel:
    """Where PERMIT must be low: `low_from` this cycle on, and `changes` edges were made by then."""

    low_from: int | None = None
    changes: int | None = None

    def allow(self) -> None:
        """PERMIT may be high."""
        self.low_from = self.changes = None


@dataclass
class BoardModel:
    """A board: its axes, PERMIT, whether a fault is latched, and the faults that may be."""

    axes: list[AxisModel]
    clock_hz: int = 0  # what comes, not what the board expects
    permit: PermitModel = field(default_factory=PermitModel)
    latched: bool | None = False  # None: not known
    estop: bool = False  # pressed,
    pressed: int = 0  #      since this cycle
    expected: set[str] = field(default_factory=set)
    steps_zero: list[int] = field(default_factory=list)  # steps made where the position is 0
    may_be_armed: bool = False  # an axis, as far as is known
    told_permit: bool = False  # a broadcast may switch PERMIT on or off: none was confirmed yet

    def learn(self, action: actions.Action, outcome: ActionOutcome) -> None:
        """Take note of what was done."""
        match action:
            case actions.BoardOrder(name, mask):
                self._order(name, mask, outcome)
            case actions.Coils(first, values):
                self._coils(first, values, outcome)
            case actions.PinInput(signal, _, level):
                self._pin(signal, level, outcome.done)
            case actions.ClockCommand():
                self.expected |= clock_faults()
            case actions.QueueBlock():
                self._block(action)
            case actions.Setting("bus_timeout_ms"):
                self.expected.add("bus_silent")
            case actions.Frequency(hz):
                if hz != self.clock_hz:
                    self.expected |= clock_faults()
            case actions.Supply(what):
                self._supply(what)

    def _order(self, name: str, mask: int, outcome: ActionOutcome) -> None:
        if outcome.taken is False:
            return
        axes = [axis for number, axis in enumerate(self.axes) if mask >> number & 1]
        if name == "arm" and self.latched is not True:
            self.may_be_armed = True
            for axis in axes:
                axis.free()
        elif name in ENDING and outcome.taken:
            for axis in axes:
                axis.halt(outcome.done)
        elif name == "clear_fault":
            self.latched = False if outcome.taken else None
        elif name == "go":
            self.expected |= {"wrong_token", "start_late"}
        self._order_permit(name, outcome)

    def _order_permit(self, name: str, outcome: ActionOutcome) -> None:
        if name == "permit_on" and (outcome.taken or self.latched is not True):
            self.permit.allow()
        elif name in ("stop", "permit_off") and outcome.taken:
            self.permit.low_from = outcome.done
        if name in ("stop", "permit_on", "permit_off") and outcome.taken is None:
            self.told_permit = True

    def _coils(self, first: int, values: tuple[int, ...], outcome: ActionOutcome) -> None:
        for place, value in enumerate(values, first):
            name = coil_command(place, value)
            if name:
                self._order(name, 1 << place % _COIL_GROUP, outcome)

    def _pin(self, signal: str, level: int, cycle: int) -> None:
        if signal.startswith("LIMIT"):
            self.expected.add(signal.lower())
        if signal == "ESTOP" and level == 0 and not self.estop:
            self._press(cycle)
        elif signal == "ESTOP" and level:
            self._release(cycle)

    def _press(self, cycle: int) -> None:
        self.estop, self.pressed, self.latched = True, cycle, True
        self.expected.add("estop")
        self.permit.low_from, self.permit.changes = cycle + ESTOP_CYCLES, None
        for axis in self.axes:
            axis.halt(cycle + ESTOP_CYCLES)

    def _release(self, cycle: int) -> None:
        """What was pressed for a moment only may not have been confirmed."""
        if self.estop and cycle < self.pressed + ESTOP_CYCLES:
            self.latched = None
            self.permit.allow()
            for axis in self.axes:
                axis.halted = None
        self.estop = False

    def _block(self, action: actions.QueueBlock) -> None:
        mark = action.entries[0][0]
        if mark & _MARK_SEEK:
            self.expected |= {"home_not_found", "home_stuck"}
        if action.entries[-1] != (2, 0):
            self.expected.add("starved")

    def _supply(self, what: str) -> None:
        """RAM is lost or begun anew: so are positions, lines and faults."""
        self.steps_zero = []
        self.latched = what == "brownout"
        if what == "brownout":
            self.expected.add("reset")


def clock_faults() -> set[str]:
    """Return the faults that a wrong pixel clock may cause."""
    return {fault.name for fault in regs.faults().values() if "clock" in fault.name}


def coil_command(coil: int, value: int) -> str:
    """Return the command that a coil stands for, empty for none."""
    if coil >= regs.COIL_CLEAR:
        return {
            (regs.COIL_CLEAR, 1): "clear_fault",
            (regs.COIL_PERMIT, 0): "permit_off",
            (regs.COIL_PERMIT, 1): "permit_on",
        }.get((coil, value), "")
    group = (("disable", "enable"), ("disarm", "arm"), ("", "stop"))
    return group[coil // _COIL_GROUP][value]
