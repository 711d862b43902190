# SPDX-License-Identifier: MIT
"""A board as the drives of its motors see it: looked at again and again, lost, found, reset.

A look is one short request: status, switches and the registers of the axes as they were at one
instant (two requests on a bus that wants short ones). A board that does not answer is asked again
after pauses that grow, with little patience, so that the other boards of the bus go on.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from pixstep.board import capability, settings
from pixstep.board import registers as regs
from pixstep.board.capability import BoardCapability
from pixstep.board.device import Device
from pixstep.board.errors import BoardError, BusyError, LineLostError, NoReplyError
from pixstep.board.link import Link
from pixstep.board.registers import places, read_by_name
from pixstep.board.state import Switches
from pixstep.errors import PlainError

MOVING_S, RESTING_S = 0.1, 0.5  # between two looks
_PATIENCE_S = 0.15  # for the reply to a look; other requests have the bus's patience
_RETRIES = 1
_PAUSES_S = (0.2, 0.5, 1.0, 2.0, 4.0)  # between two questions to a board that does not answer
_FIRST, _LAST = "status", "inputs"
_SURE_S = 60.0
_HALF_WORD, _HALF = 0x8000, 0x80000000
MOVING_STATES = ("armed", "running")


@dataclass(frozen=True)
class AxisLook:
    """One axis at one instant; positions are those of the board's register."""

    state: str
    position_steps: int
    lines_done: int
    registers: dict[str, int]
    stopping: bool
    switches: Switches

    @property
    def moves(self) -> bool:
        """True if the axis moves or is about to."""
        return self.stopping or self.state in MOVING_STATES


@dataclass(frozen=True)
class BoardSnapshot:
    """A board at one instant."""

    time_s: float
    period_ticks: int
    fault: str
    fault_axis: int
    estop: bool
    frames: int
    edges: int
    axes: tuple[AxisLook, ...]

    @property
    def fresh(self) -> bool:
        """True if no axis has had a line since the board's reset."""
        return not any(axis.registers["next_block"] or axis.lines_done for axis in self.axes)

    def follows_reset_since(self, before: BoardSnapshot) -> bool:
        """True if the board was reset since an earlier look: what only counts up is lower."""
        if self.fresh and not before.fresh:
            return True
        if self.time_s - before.time_s > _SURE_S:  # the count of frames may have wrapped
            return False
        frames = (self.frames - before.frames) % 0x10000
        edges = (self.edges - before.edges) % 0x100000000
        return frames >= _HALF_WORD or edges >= _HALF


class BoardWatch:
    """One board; every method but `pause_s` may raise BoardError.

    `wanted_hz` is the frequency of the clock's edges that the board is to be set to, and `divider`
    how many of them are a pixel; None leaves the board's. A board of another `kind` than that is
    told nothing, and counts as one that does not answer; None takes any.
    """

    def __init__(
        self,
        link: Link,
        unit: int,
        axes: int,
        wanted_hz: Fraction | None = None,
        divider: int | None = None,
        axes_together: int | None = None,
        kind: str | None = None,
    ) -> None:
        self.link, self.unit = link, unit
        self.board: Device = link.board(unit)
        self.limits: BoardCapability | None = None
        """What the board can do; None before it was first reached."""
        self.newest: BoardSnapshot | None = None
        self.failures = 0
        """Requests in a row without an answer."""
        self.trouble = ""
        """Why the board cannot be asked, in words; "" if it can."""
        self.resets = 0
        self.due_s = 0.0
        """When it is to be looked at next."""
        self.seeks: object = None
        """Whose switch is sought: one axis of a board at a time."""
        self._axes, self._together = axes, axes_together or axes
        self._wanted_hz, self._divider, self._kind = wanted_hz, divider, kind
        self._period_ticks = 0
        self._home_is_limit = 0

    @property
    def pixel_hz(self) -> float:
        """The frequency of its pixels."""
        return float(self.limits.pixel_hz) if self.limits else 1.0

    @property
    def top_steps_px(self) -> int:
        """The highest speed of plain lines, all of its motors moving together."""
        if self.limits is None:
            return 1
        return int(self.limits.shortest_ticks // max(1, self.limits.min_interval_ticks))

    @property
    def turns_below_steps_px(self) -> int:
        """The highest speed at which a plain line turns from one pixel to the next."""
        if self.limits is None:
            return 1
        speed = int(self.limits.shortest_ticks // max(1, self.limits.reversal_ticks))
        return min(speed, self.limits.start_stop_steps or speed)

    @property
    def rest_px(self) -> int:
        """Pixels of rest with which it turns at any speed."""
        if self.limits is None:
            return 1
        return max(1, -int(-self.limits.reversal_ticks // self.limits.shortest_ticks))

    @property
    def pause_s(self) -> float:
        """How long a board that does not answer is left alone."""
        return _PAUSES_S[min(self.failures, len(_PAUSES_S)) - 1]

    def look(self) -> BoardSnapshot:
        """Look at the board; the settings are asked for again if the pixel period has changed."""
        try:
            with self.guarded(), self._impatient():
                found = self._read()
                if self.limits is None or found.period_ticks != self._period_ticks:
                    self._learn()
                    found = self._read()
        except BoardError as error:
            if not self.failures:  # it answers, and not as a board that this tool knows
                self.failures, self.trouble = 1, str(error)
            raise
        if self.newest is not None and found.follows_reset_since(self.newest):
            self.resets += 1
            self._learn()
        self.newest, self._period_ticks = found, found.period_ticks
        self.failures, self.trouble = 0, ""
        return found

    def look_soon(self) -> None:
        """Let it be looked at as soon as the bus is free, unless it does not answer."""
        if not self.failures:
            self.due_s = 0.0

    @contextlib.contextmanager
    def guarded(self) -> Iterator[None]:
        """Count what goes unanswered; the board is asked with pauses then."""
        try:
            yield
        except (NoReplyError, LineLostError) as error:
            self.failures += 1
            self.trouble = str(error)
            raise
        except BoardError:
            raise
        except PlainError as error:  # the bus is another program's, or the port cannot be opened
            self.failures += 1
            self.trouble = str(error)
            raise BoardError(str(error)) from None

    @contextlib.contextmanager
    def _impatient(self) -> Iterator[None]:
        modbus = self.link.modbus
        timeout_s = min(_PATIENCE_S, modbus.patience[0])
        retries = 0 if self.failures else min(_RETRIES, modbus.patience[1])
        with modbus.turns, modbus.patient(timeout_s, retries):
            yield

    def _learn(self) -> None:
        """Ask for what the board can do; set its clock if it is another one and can be set now."""
        found = self.board.who().board
        if self._kind not in (None, found):
            raise BoardError(f"board {self.unit} is a {found}, and should be a {self._kind}")
        with contextlib.suppress(BusyError):  # something runs: motions go by the board's clock
            settings.set_clock(self.board, self._wanted_hz, divider=self._divider)
        self.limits = capability.connected_limits(self.board, axes=self._together)
        self._home_is_limit = settings.read(self.board).get("home_is_limit", 0)

    def _read(self) -> BoardSnapshot:
        table = self.board.map
        first, last = table.input(_FIRST), table.input(_LAST)
        head = [one for one in table.inputs if first.address <= one.address <= last.address]
        end = regs.AXIS_BASE + regs.AXIS_STRIDE * self._axes
        now_s = self.link.world.now_s()
        if end - first.address <= self.link.modbus.most_words:
            words = self.board.read_inputs(first.address, end - first.address)
            state = read_by_name(
                places(head), lambda at, count: words[at - first.address :][:count]
            )
            blocks = words[regs.AXIS_BASE - first.address :]
        else:  # the status first: an axis that is not stopping then rests when it is read
            state = self.board.inputs_from(_FIRST, _LAST)
            blocks = self.board.read_inputs(regs.AXIS_BASE, regs.AXIS_STRIDE * self._axes)
        axes = [blocks[regs.AXIS_STRIDE * axis :] for axis in range(self._axes)]
        return _look(now_s, state, [self._axis(block) for block in axes], self._home_is_limit)

    def _axis(self, block: list[int]) -> dict[str, int]:
        return read_by_name(
            places(self.board.map.axis_inputs), lambda first, count: block[first : first + count]
        )


def _look(
    now_s: float, state: dict[str, int], axes: list[dict[str, int]], home_is_limit: int
) -> BoardSnapshot:
    """Return a look of what was read."""
    flags = regs.flags(state["status"])
    code = state["fault_code"]
    return BoardSnapshot(
        time_s=now_s,
        period_ticks=state["pixel_period_ticks"],
        fault=regs.code_name(regs.faults(), code) if code else "",
        fault_axis=state["fault_axis"],
        estop=flags["estop"],
        frames=state["frames_ok"],
        edges=state["pixel_edges"],
        axes=tuple(
            AxisLook(
                regs.axis_state(found["axis_state"]),
                found["position_steps"],
                found["lines_done"],
                found,
                bool(state["status"] >> (regs.STATUS_STOPPING + axis) & 1),
                _switches(state["inputs"] >> 4 * axis, home_is_limit >> 2 * axis),
            )
            for axis, found in enumerate(axes)
        ),
    )


def _switches(bits: int, home_is_limit: int) -> Switches:
    """Return the switches of an axis; its home switch may be a limit switch, too."""
    home = bits & 1
    minus, plus = bits >> 1 | home & home_is_limit, bits >> 2 | home & home_is_limit >> 1
    return Switches(bool(home), bool(minus & 1), bool(plus & 1))
