# SPDX-License-Identifier: MIT
"""What goes into the record's model and what comes out: statuses, commands, posts.

All positions are raw: steps of the motor, or counts of its encoder. Times are in seconds.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntFlag, StrEnum
from typing import Protocol


def whole(steps: float | None) -> int:
    """Return a position in whole steps, half a step rounded up: the motor goes there.

    Raises ValueError or OverflowError for what is no number.
    """
    return math.floor((steps or 0.0) + 0.5)


class Msta(IntFlag):
    """The bits of the record's field MSTA, as the motor's driver gives them."""

    DIRECTION = 1 << 0
    """The last motion went in the positive raw direction."""
    DONE = 1 << 1
    """The motor rests, and what it was asked for is over."""
    PLUS_LS = 1 << 2
    HOME = 1 << 3
    """The home switch is active."""
    EA_SLIP = 1 << 4
    EA_POSITION = 1 << 5
    """The driver holds the position in a closed loop (torque is on)."""
    SLIP_STALL = 1 << 6
    EA_HOME = 1 << 7
    EA_PRESENT = 1 << 8
    """There is an encoder."""
    PROBLEM = 1 << 9
    MOVING = 1 << 10
    GAIN_SUPPORT = 1 << 11
    COMM_ERR = 1 << 12
    MINUS_LS = 1 << 13
    HOMED = 1 << 14


@dataclass(frozen=True)
class Status:
    """The motor at one instant, as its driver sees it."""

    position_steps: int = 0
    encoder_counts: int = 0
    """0 where there is no encoder."""
    flags: Msta = Msta.DONE
    speed_steps_per_s: float = 0.0
    """The raw speed, without sign."""


class Verb(StrEnum):
    """What the record can ask of the motor. The arguments are raw: steps, steps/s, steps/s2."""

    SET_VELOCITY = "SET_VELOCITY"
    SET_VEL_BASE = "SET_VEL_BASE"
    SET_ACCEL = "SET_ACCEL"
    MOVE_ABS = "MOVE_ABS"
    """Notes a target; GO begins."""
    MOVE_REL = "MOVE_REL"
    """Notes a distance; GO begins."""
    HOME_FOR = "HOME_FOR"
    HOME_REV = "HOME_REV"
    GO = "GO"
    JOG = "JOG"
    """Moves at a signed speed until STOP_AXIS or a limit."""
    JOG_VELOCITY = "JOG_VELOCITY"
    """Changes the signed speed of a jog under way."""
    STOP_AXIS = "STOP_AXIS"
    LOAD_POS = "LOAD_POS"
    """The position where the motor is becomes the argument; nothing moves."""
    GET_INFO = "GET_INFO"
    """A new status is wanted, although nothing moves."""
    SET_HIGH_LIMIT = "SET_HIGH_LIMIT"
    """The highest raw position that soft limits allow. A driver may know limits of its own."""
    SET_LOW_LIMIT = "SET_LOW_LIMIT"
    ENABLE_TORQUE = "ENABLE_TORQUE"
    """Hold the position in a closed loop. Asked only of a driver with GAIN_SUPPORT."""
    DISABL_TORQUE = "DISABL_TORQUE"
    SET_PGAIN = "SET_PGAIN"
    """A gain of the closed loop, 0 to 1. Asked only of a driver with GAIN_SUPPORT."""
    SET_IGAIN = "SET_IGAIN"
    SET_DGAIN = "SET_DGAIN"


@dataclass(frozen=True)
class MotorCommand:
    """One thing that the record asks of the motor. `str()` gives it as the traces write it."""

    verb: Verb
    argument: float | None = None

    def __str__(self) -> str:
        return self.verb if self.argument is None else f"{self.verb} {self.argument:.10g}"


@dataclass(frozen=True)
class Post:
    """A monitor: a field and the value that clients are to see, in the order of the record."""

    field: str
    value: float | str


@dataclass(frozen=True)
class Outcome:
    """What one event, a write or a status, has brought about."""

    commands: tuple[MotorCommand, ...] = ()
    """What the motor is to do, in this order."""
    posts: tuple[Post, ...] = ()
    """What clients are to be told, in this order."""
    second_leg: tuple[MotorCommand, ...] = ()
    """What the record will ask for when the move in `commands` ends at its target, if nothing comes
    between: the final approach against backlash. A driver may queue it back to back; the record
    gives the same commands again when it sees the first leg end, and they are not to move twice."""
    delay_s: float | None = None
    """If not None, the record waits for so long (DLY) and is to be told then: `delay_over()`."""
    complete: bool = False
    """True where the record's forward link runs: writes that wait for completion end now."""


class Drive(Protocol):
    """What moves one motor for a record. All calls return at once, from any thread."""

    def connect(self, on_status: Callable[[Status], None]) -> None:
        """Begin to report: `on_status` is called from the driver's own thread.

        It is called with each status while the motor moves, with the first one at rest (DONE)
        after each motion, after each command that starts, stops or loads something, after GET_INFO,
        and when flags change. The order of statuses is that of the events.
        """

    def obey(
        self, commands: Sequence[MotorCommand], second_leg: Sequence[MotorCommand] = ()
    ) -> None:
        """Take the commands of one Outcome, in order; they are carried out soon."""

    def overtaken(self, status: Status) -> bool:
        """Whether a status that was reported is older than the newest call of `obey`.

        A motor that rested before a GO would else look like the end of the move: such a status is
        dropped, and a newer one follows.
        """

    @property
    def offset_steps(self) -> int:
        """What the driver adds to its board's register; 0 of one whose board counts positions."""

    def add_offset(self, steps: int) -> None:
        """Take over the offset that an earlier driver had: before the first command."""

    @property
    def problem(self) -> str:
        """Why PROBLEM or COMM_ERR is set, in words; "" if neither is, or nothing is known."""

    @property
    def stopped_elsewhere(self) -> bool:
        """Whether another program has stopped the last motion: no retry is to follow it."""

    def close(self) -> None:
        """Stop the motor if this driver moves it, report nothing more, and leave."""
