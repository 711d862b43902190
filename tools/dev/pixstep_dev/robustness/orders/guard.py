# SPDX-License-Identifier: MIT
"""A world with the model beside it: every action is judged."""

from collections.abc import Callable
from typing import Any

from pixstep.board import registers as regs
from pixstep.simulation.simulator import PermitOutput
from pixstep_dev.robustness.orders import actions
from pixstep_dev.robustness.orders.actions import ASK, Action, BoardOrder
from pixstep_dev.robustness.orders.model import (
    ESTOP_ENTRY_CYCLES,
    HELD_CYCLES,
    AxisModel,
    BoardModel,
)
from pixstep_dev.robustness.orders.state import MOVING, AxisRegisters, AxisStepEdges, BoardReading
from pixstep_dev.robustness.orders.world import IDLE_TICKS, ActionOutcome, OrdersWorld

MARGIN_CYCLES = 16_000  # of the main loop, from a halt to the axis's being free again
_LEAD_STEPS = 2  # a position counts a step when its period is loaded; the timer holds two periods
_LOOKS = 5  # at the accounts of time behind a reset, at most
_TIME_TICKS = 2 * IDLE_TICKS  # an idle period is accounted for as a whole, late by one at most
_ROUND_S = 0.008  # of the main loop at most, building a reply included
_ANSWERS = {True: "done", False: "refused", None: "no answer"}
_STAYS = ("command", "settings", "outputs")

_Before = tuple[BoardReading | None, dict[str, Any]]  # what the board said, and its registers


class Guard:
    """Does actions and judges them; `complaints` tells what did not hold."""

    def __init__(self, world: OrdersWorld) -> None:
        self.world = world
        self.careful = False  # compare what a refusal must leave as it was
        self.complaints: list[str] = []
        self.seen_faults: set[str] = set()
        self.started = ""  # which of the axes armed together did start
        self.say: Callable[[str], None] | None = None  # told of every action
        self.begin()

    def begin(self) -> None:
        """The board rests, without a fault: begin anew from what it says now."""
        self.model = BoardModel([AxisModel() for _ in range(self.world.axes)], self.world.clock_hz)
        state = self.state = self.world.look()
        assert state  # it rests: it answers
        self.counted = [self.world.edges(number).made for number in range(self.world.axes)]
        for number, axis in enumerate(self.model.axes):
            edges = self.world.edges(number)
            axis.settle(edges.made)
            self.model.steps_zero.append(edges.steps - state.axes[number].position)
        self.note_time()

    def complain(self, text: str) -> None:
        """Take note of what did not hold, with the cycle."""
        self.complaints.append(f"cycle {self.world.cycle}: {text}")
        if self.say:
            self.say(f"        FAIL {text}")

    def do(self, action: Action) -> ActionOutcome:
        """Do an action, learn from it and check what can be seen from outside."""
        begun = self.world.cycle
        outcome = self._do(action)
        if self.say:
            self.say(f"{begun:>12} {actions.text(action)}: {_ANSWERS[outcome.taken]}")
        return outcome

    def _do(self, action: Action) -> ActionOutcome:
        if isinstance(action, actions.Look):
            state = self.look()
            if self.say and state:
                self.say(f"             {state.summary()}")
            return ActionOutcome(True, self.world.cycle)
        before = self._before(action)
        permit = self.world.permit() if self._presses(action) else None
        outcome = self.world.perform(action)
        self.model.learn(action, outcome)
        if permit:
            self._expect_permit(permit)
        if isinstance(action, actions.Supply):
            self._restart()
        self._judge_answer(action, outcome)
        self.check()
        if before and outcome.taken is False:
            self._compare(action, outcome, before)
        return outcome

    def _presses(self, action: Action) -> bool:
        return action == actions.PinInput("ESTOP", 0, 0) and not self.model.estop

    # ---- what can be seen at any time ----

    def check(self) -> None:
        """Compare edges and PERMIT with what the model allows."""
        for number, axis in enumerate(self.model.axes):
            self._check_edges(number, axis)
        self._check_permit()

    def _check_edges(self, number: int, axis: AxisModel) -> None:
        edges = self.world.edges(number)
        if axis.rest is not None:
            if edges.made != axis.rest:
                self.complain(
                    f"axis {number}: {edges.made - axis.rest} edges out of rest, the last at "
                    f"{edges.last}"
                )
                axis.rest = edges.made
        elif axis.halted is not None:
            if edges.before > axis.halted or edges.last > axis.halted + HELD_CYCLES:
                self.complain(
                    f"axis {number}: halted by {axis.halted}, edges at {edges.before} and "
                    f"{edges.last}"
                )
                axis.halted = None
            elif self.world.cycle > axis.halted + HELD_CYCLES:
                axis.settle(edges.made)

    def _expect_permit(self, before: PermitOutput) -> None:
        """The stop was pressed: PERMIT falls once if it is high, and nothing else happens to it."""
        if before.level or not self.model.told_permit:
            self.model.permit.changes = before.changes + before.level

    def _check_permit(self) -> None:
        permit, model = self.world.permit(), self.model.permit
        if self.model.estop and permit.rise > self.model.pressed + ESTOP_ENTRY_CYCLES:
            self.complain(
                f"PERMIT rose at {permit.rise}, the emergency stop was pressed at "
                f"{self.model.pressed}"
            )
            self.model.pressed = permit.rise
        if model.low_from is None or self.world.cycle < model.low_from:
            return
        if model.changes is None:
            model.changes = permit.changes
            late = permit.cycle > model.low_from
        else:
            late = permit.changes != model.changes
        if permit.level or late:
            self.complain(
                f"PERMIT must be low from {model.low_from}: level {permit.level}, "
                f"{permit.changes} edges, the last at {permit.cycle}; expected {model.changes}"
            )
            model.allow()

    # ---- answers ----

    def _judge_answer(self, action: Action, outcome: ActionOutcome) -> None:
        """Some answers follow from the command alone."""
        if getattr(action, "how", "") != ASK:
            return
        if outcome.taken is None:
            self.complain(f"no reply to {actions.text(action)}")
        elif isinstance(action, BoardOrder):
            wanted = self._wanted(action)
            if wanted is not None and outcome.taken != wanted:
                self.complain(
                    f"{actions.text(action)}: {'taken' if outcome.taken else 'refused'}, exception "
                    f"{outcome.exception}"
                )

    def _wanted(self, order: BoardOrder) -> bool | None:
        """Return whether an order must be taken, None if that depends on more than is known."""
        quiets = order.name in ("disarm", "stop")
        if quiets and order.mask & self.world.all_axes == 0:
            return False
        on_axes = order.name in ("arm", "discard", "enable", "disable", "zero")
        if on_axes and not 0 < order.mask <= self.world.all_axes:
            return False
        if order.name in ("stop", "enable", "permit_off"):
            return True
        if self.model.latched and order.name in ("arm", "permit_on"):
            return False
        if self.model.estop and order.name == "clear_fault":
            return False
        if order.name == "go" and not (order.ahead and self.model.may_be_armed):
            return False
        if order.name in ("store", "default_settings") and order.argument != regs.STORE_KEY:
            return False
        return None

    # ---- what the board says ----

    def look(self) -> BoardReading | None:
        """Read the state; compare it with edges, PERMIT and itself."""
        before = [self.world.edges(number) for number in range(self.world.axes)]
        state = self.world.look()
        if state is None:
            self.complain("no reply to a reading")
            return None
        self.model.told_permit = False
        self._judge_fault(state)
        for number, axis in enumerate(state.axes):
            self._judge_axis(number, axis, state, before[number])
        self.check()
        self.state = state
        return state

    def _judge_fault(self, state: BoardReading) -> None:
        model = self.model
        name = state.fault_name
        self.seen_faults.add(name)
        if state.fault and name not in model.expected:
            self.complain(f"unexpected fault {name}, argument {state.argument}")
            model.expected.add(name)
        if state.fault:
            if model.permit.low_from is None or model.permit.low_from > state.told:
                model.permit.low_from = state.told
            if any(axis.state in MOVING for axis in state.axes):
                self.complain(f"axes move in a fault: {state.summary()}")
        elif any(axis.state == "fault" for axis in state.axes):
            self.complain(f"an axis is at fault, the board is not: {state.summary()}")
        elif model.estop and not self._lags(state):
            self.complain("the emergency stop is pressed and there is no fault")
        permit = self.world.permit()
        steady = permit.cycle < state.asked and not self._lags(state)
        if steady and state.flag("permit") != bool(permit.level):
            self.complain(f"PERMIT is {permit.level}, `status` says otherwise: {state.summary()}")
        model.latched = bool(state.fault) or model.estop
        model.may_be_armed = any(axis.state == "armed" for axis in state.axes)

    def _lags(self, state: BoardReading) -> bool:
        """The main loop hears of the emergency stop behind its interrupt, a round later."""
        return self.model.estop and state.told < self.model.pressed + self.world.sim.cycles(
            _ROUND_S
        )

    def _judge_axis(
        self, number: int, axis: AxisRegisters, state: BoardReading, before: AxisStepEdges
    ) -> None:
        """Where the state says that the axis does not move, no edge may follow."""
        model = self.model.axes[number]
        edges = self.world.edges(number)
        if axis.state == "armed" and model.armed is not None and before.made != model.armed:
            self.complain(f"axis {number}: {before.made - model.armed} edges while armed")
        if axis.state in MOVING:
            if self._lags(state):
                pass
            elif model.rest is not None or model.halted is not None:
                self.complain(f"axis {number}: {axis.state}, and was never armed since it was not")
                model.free()
        elif axis.state in ("empty", "fault"):
            model.halt(state.told)
        elif model.rest is None:
            model.settle(edges.made)
        self._judge_position(number, axis, model, edges)
        self.counted[number] = before.made

    def _judge_position(
        self, number: int, axis: AxisRegisters, model: AxisModel, edges: AxisStepEdges
    ) -> None:
        """At rest the position is the steps made; in motion it is no older than the reading before.

        A reading may be as old as the board's last account of the axis: while a captured clock edge
        waits to be served, the board does not bring it up to date.
        """
        known = axis.position + self.model.steps_zero[number]
        rests = model.rest is not None or (
            model.halted is not None and self.world.asked > model.halted + HELD_CYCLES
        )
        bound = 0 if rests else edges.made - self.counted[number] + _LEAD_STEPS
        if abs(known - edges.steps) > bound:
            self.complain(
                f"axis {number}, {axis.state}: position {known}, {edges.steps} steps made"
            )
            self.model.steps_zero[number] += edges.steps - known

    # ---- a refusal changes nothing ----

    def _before(self, action: Action) -> _Before | None:
        if not self.careful or getattr(action, "how", "") != ASK:
            return None
        return self.world.look(), self.world.registers()

    def _compare(self, action: Action, outcome: ActionOutcome, before: _Before) -> None:
        old, old_registers = before
        new, new_registers = self.world.look(), self.world.registers()
        if old is None or new is None:
            self.complain("no reply to a reading")
            return
        for name in _STAYS:
            if old_registers[name] != new_registers[name] and new.fault == old.fault:
                self.complain(
                    f"refused {actions.text(action)} changed {name}: {old_registers[name]} to "
                    f"{new_registers[name]}"
                )
        for number, (was, is_now) in enumerate(zip(old.axes, new.axes, strict=True)):
            if was.state not in MOVING and self.model.axes[number].halted is None:
                self._compare_axis(action, number, was, is_now)

    def _compare_axis(
        self, action: Action, number: int, was: AxisRegisters, is_now: AxisRegisters
    ) -> None:
        mine = isinstance(action, actions.QueueBlock) and action.axis == number
        for name in ("state", "queue_free", "next_block", "position", "lines_done", "line_error"):
            if mine and (name == "line_error" or (name, is_now.state) == ("state", "refused")):
                continue
            old, new = getattr(was, name), getattr(is_now, name)
            if old != new:
                self.complain(
                    f"refused {actions.text(action)}: axis {number}: {name} {old} is now {new}"
                )

    def _restart(self) -> None:
        """Behind a reset every position is 0 and every axis rests."""
        self.model.permit.allow()
        for number, axis in enumerate(self.model.axes):
            edges = self.world.edges(number)
            axis.settle(edges.made)
            self.model.steps_zero.append(edges.steps)
        self.note_time()

    # ---- time ----

    def note_time(self) -> None:
        """Note each axis's account of time as two looks in a row have it.

        One look may meet the board while it writes its account.
        """
        for _ in range(_LOOKS):
            self.accounts = self._accounts()
            self.world.perform(actions.Wait(IDLE_TICKS))
            if all(abs(off) <= _TIME_TICKS for off in self._times_off()):
                break

    def _accounts(self) -> list[int]:
        return [self.world.account(number) for number in range(self.world.axes)]

    def _check_time(self) -> None:
        """At rest every axis has counted the ticks that have passed.

        A second look decides: the first may have met the board while it wrote its account.
        """
        if any(abs(off) > _TIME_TICKS for off in self._times_off()):
            self.world.perform(actions.Wait(IDLE_TICKS))
            for number, off in enumerate(self._times_off()):
                if abs(off) > _TIME_TICKS:
                    self.complain(f"axis {number}: its account of time is off by {off} ticks")

    def _times_off(self) -> list[int]:
        return [
            (self.world.account(number) - old + (1 << 31)) % (1 << 32) - (1 << 31)
            for number, old in enumerate(self.accounts)
        ]

    # ---- the end of a trial ----

    def recover(self) -> bool:
        """Take the board to rest without a fault; False if it does not come there."""
        failed = len(self.complaints)
        world = self.world
        for signal, axis in sorted(world.driven):
            self.do(actions.PinInput(signal, axis, 1))
        world.driven.clear()
        if world.clock_touched:
            for text in ("on", "ppm 0", f"hz {world.clock_hz}/1"):
                self.do(actions.ClockCommand(text))
            world.clock_touched = False
        self.do(BoardOrder("stop", world.all_axes))
        self.do(actions.Wait(HELD_CYCLES + MARGIN_CYCLES))
        for order in (BoardOrder("clear_fault", 0), BoardOrder("discard", world.all_axes)):
            outcome = self.do(order)
            if not outcome.taken:
                self.complain(f"recovery: {order.name} refused, exception {outcome.exception}")
        state = self.look()
        if state and (state.fault or any(axis.state != "empty" for axis in state.axes)):
            self.complain(f"not recovered: {state.summary()}")
        self._check_time()
        self.model.expected.clear()
        return len(self.complaints) == failed
