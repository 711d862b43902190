# SPDX-License-Identifier: MIT
"""Homing on a board: find the home switch, take its edge as position 0, stand on it.

start closed? back off, until it opens
approach      up to the homing speed, until the switch closes; slows down behind it
back off      the same the other way, until it opens; then clear of it
slow approach at one slow speed, until it closes: this edge, captured by hardware, counts
zero          position 0 is where that edge was
return        by a move of its own onto 0

What seeks the switch is smooth or plain as the plan says; the moves between are plain.
"""

from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import TypedDict, cast

from pixstep.board import registers as regs
from pixstep.board import run
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.link import World
from pixstep.board.state import TRIP_CLOSED, TRIP_NONE, TRIP_OPENED, Trip
from pixstep.board.upload import LineUpload, require_idle
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.runs import MARK_SMOOTH, Seek, queue_entries, seek_entries
from pixstep.moves import fast
from pixstep.moves.legs import HomingPlan
from pixstep.progress import Progress, unseen

LEGS = ("leave the switch", "approach", "back off", "stand clear", "slow approach", "return to 0")
_LEAVE, _APPROACH, _BACK_OFF, _CLEAR, _SLOW, _RETURN = LEGS
_SEEK = "seek"
_POLL_S = 0.005
# A leg that gets on is waited for, however slowly it does: a simulated board may take longer than
# the leg's own time. So long without a step, a pixel or another state, and so many pixels, end it.
_PATIENCE_S = 2.0
_PATIENCE_PX = 8
_MOVES = ("axis_state", "pixel", "position_steps")
_NOT_SEEN = {"home_not_found": "close", "home_stuck": "open"}
_LIMITS = {"limit_minus": "minus", "limit_plus": "plus"}


@dataclass(frozen=True)
class HomingLeg:
    """One leg as it was made: positions in steps (the board's register), times in seconds."""

    name: str
    first_steps_px: int  # as planned
    top_steps_px: int
    start_steps: int
    end_steps: int
    pixels: int
    began_s: float
    ended_s: float
    trip: Trip | None = None
    decode: str = PLAIN

    @property
    def steps(self) -> int:
        """Signed steps moved."""
        return self.end_steps - self.start_steps


class LegData(TypedDict):
    """A leg as plain data."""

    name: str
    first_steps_px: int
    top_steps_px: int
    start_steps: int
    end_steps: int
    pixels: int
    began_s: float
    ended_s: float
    trip: dict[str, int] | None
    decode: str
    steps: int


@dataclass(frozen=True)
class Homed:
    """A finished homing; the legs' positions are those before the zero, but for the last one's."""

    plan: HomingPlan
    legs: tuple[HomingLeg, ...]
    edge: Trip
    zeroed_steps: int  # position by the register just after zero: steps moved since the edge
    position_steps: int  # at the end

    def as_json(self) -> dict[str, object]:
        """Return plain data."""
        return {
            "axis": self.plan.axis, "direction": self.plan.towards, "edge": asdict(self.edge),
            "beyond_edge_steps": self.zeroed_steps, "position_steps": self.position_steps,
            "legs": legs_as_json(self.legs),
        }  # fmt: skip


class HomingError(BoardError):
    """Homing ended in a fault: its name (empty if it is none of the board's), the legs so far."""

    def __init__(self, message: str, name: str = "", legs: tuple[HomingLeg, ...] = ()) -> None:
        super().__init__(message)
        self.name, self.legs = name, legs


def legs_as_json(legs: tuple[HomingLeg, ...]) -> list[LegData]:
    """Return legs as plain data."""
    return [cast("LegData", asdict(leg) | {"steps": leg.steps}) for leg in legs]


def home(
    board: Device, plan: HomingPlan, pixel_hz: Fraction, world: World, progress: Progress = unseen,
    *, lines: run.LinesOfBoard | None = None,
) -> Homed:  # fmt: skip
    """Home one axis, at rest and enabled; return what was found. `lines` shows its state meanwhile.

    Raises HomingError naming the fault (home_not_found, home_stuck, limit_minus, limit_plus or
    any other), BoardError if the board does not answer or refuses a leg. The fault stays latched.
    """
    return _HomingLegs(board, plan, pixel_hz, world, progress, lines).go()


def seek(
    board: Device, plan: HomingPlan, pixel_hz: Fraction, world: World, progress: Progress = unseen,
    *, lines: run.LinesOfBoard | None = None, opens: bool = False,
) -> HomingLeg:  # fmt: skip
    """Move one axis, at rest and enabled, until its home switch closes, or opens; return the leg.

    Its trip is None if the switch was as sought from the start. Raises what `home` raises.
    """
    legs = Legs(board, plan, pixel_hz, world, progress, lines)
    legs.names = (_SEEK,)
    legs.seek(_SEEK, plan.seek(opens=opens))
    return legs.legs[-1]


class Legs:
    """Makes legs that seek a switch or move, one after the other, on one axis."""

    names: tuple[str, ...] = LEGS

    def __init__(
        self, board: Device, plan: HomingPlan, pixel_hz: Fraction, world: World,
        progress: Progress, lines: run.LinesOfBoard | None = None,
    ) -> None:  # fmt: skip
        self.board, self.plan, self.pixel_hz = board, plan, pixel_hz
        self.world, self.progress = world, progress
        self.lines = lines or run.LinesOfBoard(board, [plan.axis])
        self.legs: list[HomingLeg] = []

    def seek(self, name: str, seek: Seek) -> Trip | None:
        """Make a seek line; return the switch's edge, None if it already was as sought."""
        wanted = TRIP_OPENED if seek.opens else TRIP_CLOSED
        self._leg(name, seek_entries(seek), wanted)
        return self.legs[-1].trip

    def move(self, name: str, steps: int) -> None:
        """Make a plain move of exactly `steps` steps, no faster than homing is."""
        self._leg(name, queue_entries(fast.plan(self.plan.ramp, steps).line(name)), 0)

    def position(self) -> int:
        """Return the board's position register, steps."""
        return self.board.axis(self.plan.axis)["position_steps"]

    def show(self, name: str, share: float) -> None:
        """Show how far all legs are: a leg's share is done."""
        self.progress((self.names.index(name) + share) / len(self.names))

    def _leg(self, name: str, entries: list[tuple[int, int]], wanted: int) -> None:
        """Upload, arm and follow a line; `wanted` is the trip it looks for, 0 for none."""
        start = self._upload(name, entries)
        runs = [(abs(count), repeat) for count, repeat in entries[2:] if repeat]
        began = self.world.now_s()
        run.arm_queued(self.lines)
        state = self._follow(name, sum(repeat for _, repeat in runs))
        trip = self.board.trip() if wanted else None
        leg = HomingLeg(
            name=name, first_steps_px=runs[0][0], top_steps_px=max(count for count, _ in runs),
            start_steps=start, end_steps=state["position_steps"], pixels=state["pixel"],
            began_s=began, ended_s=self.world.now_s(),
            trip=trip if trip and trip.code == wanted and trip.axis == self.plan.axis else None,
            decode=SMOOTH if entries[0][0] & MARK_SMOOTH else PLAIN,
        )  # fmt: skip
        self.legs.append(leg)
        in_vain = trip is not None and trip.code == TRIP_NONE
        if in_vain or state["axis_state"] != _state("done"):
            raise self._fault(leg)

    def _upload(self, name: str, entries: list[tuple[int, int]]) -> int:
        """Queue a whole leg, for one that is not all there cannot slow down; return the position.

        The axis is at rest, so its position is that of the leg's start.
        """
        state = self.board.axis(self.plan.axis)
        room = state["queue_free"]
        if len(entries) > room:
            raise HomingError(
                f"axis {self.plan.axis}: {name} takes {len(entries)} queue entries, the board has "
                f"room for {room}: fewer HAPs (now {len(self.plan.ramp.counts)}) make it shorter",
                legs=tuple(self.legs),
            )
        require_idle(self.board, [self.plan.axis])
        upload = LineUpload(self.board, self.plan.axis, entries, state)
        while not upload.done:
            if not upload.push():
                raise HomingError(f"axis {self.plan.axis}: {name} is not accepted by the queue")
        return state["position_steps"]

    def _follow(self, name: str, pixels: int) -> dict[str, int]:
        """Poll until the leg is done or a fault has stopped it; return the axis' registers."""
        patience_s = _PATIENCE_S + float(_PATIENCE_PX / self.pixel_hz)
        before, ends = None, 0.0
        while True:
            state = self.board.axis(self.plan.axis)
            self.lines.seen = {self.plan.axis: state}
            if state["axis_state"] in (_state("done"), _state("fault"), _state("refused")):
                return state
            if (now := [state[name] for name in _MOVES]) != before:
                before, ends = now, self.world.now_s() + patience_s
            elif self.world.now_s() > ends:
                raise HomingError(
                    f"axis {self.plan.axis}: {name} does not get on: for {patience_s:.3g} s "
                    f"{regs.axis_state(state['axis_state'])} in pixel {state['pixel']}",
                    legs=tuple(self.legs),
                )
            self.show(name, min(1.0, state["pixel"] / pixels))
            self.world.wait(_POLL_S)

    def _fault(self, leg: HomingLeg) -> HomingError:
        """Return the fault that stopped a leg, in words."""
        name, steps = self.board.fault_name(), abs(leg.steps)
        where = f"{leg.name}, {steps} steps after its start"
        if name in _NOT_SEEN:
            text = f"the home switch did not {_NOT_SEEN[name]} within {steps} steps ({leg.name})"
        elif name in _LIMITS:
            text = f"the {_LIMITS[name]} limit switch tripped ({where})"
        else:
            text = f"{where}: {self.board.fault_text() or 'stopped'}"
            return HomingError(f"axis {self.plan.axis}: {text}", name, tuple(self.legs))
        cure = next(fault.cure for fault in regs.faults().values() if fault.name == name)
        text = f"axis {self.plan.axis}: {name}: {text}. {cure}"
        return HomingError(text, name, tuple(self.legs))


class _HomingLegs(Legs):
    """The legs of one homing."""

    def go(self) -> Homed:
        """Go through all legs."""
        if self.board.switches(self.plan.axis).home:
            self.seek(_LEAVE, self.plan.back_off())
        self.seek(_APPROACH, self.plan.approach())
        self.seek(_BACK_OFF, self.plan.back_off())
        self.stand_clear()
        edge = self.seek(_SLOW, self.plan.slow_approach())
        if edge is None:
            raise HomingError(
                f"axis {self.plan.axis}: the home switch is closed again before the slow approach",
                legs=tuple(self.legs),
            )
        self.board.zero(self.plan.axis)
        beyond = self.position()
        if beyond:
            self.move(_RETURN, -beyond)
        return Homed(self.plan, tuple(self.legs), edge, beyond, self.position())

    def stand_clear(self) -> None:
        """Stand so far from where the switch opened that the slow approach has its speed there.

        Much further away (the back-off needs room to slow down) would only take longer.
        """
        leg = self.legs[-1]
        if leg.trip is None:
            return
        stands = self.plan.direction * (leg.trip.position_steps - leg.end_steps)
        if not self.plan.clear_steps <= stands <= 2 * self.plan.clear_steps:
            self.move(_CLEAR, self.plan.direction * (stands - self.plan.clear_steps))


def _state(name: str) -> int:
    return regs.AXIS_STATES.index(name)
