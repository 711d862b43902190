# SPDX-License-Identifier: MIT
"""What is known of one axis: the newest look at its board, and what its positions count from."""

from __future__ import annotations

from pixstep.motor_drive.seam import set_position
from pixstep.motor_drive.watch import AxisLook, BoardSnapshot


class KnownAxis:
    """One axis of a board; the bus' thread alone."""

    def __init__(self, unit: int, axis: int) -> None:
        self._unit, self._axis = unit, axis
        self.look: BoardSnapshot | None = None
        """The newest look; None before the first."""
        self.offset_steps = 0
        """What is added to the board's register: see `seam.py`."""
        self.lost = False
        """Whether the board was reset and the position is not known since."""

    @property
    def axis(self) -> AxisLook:
        """The axis at the newest look; there must be one."""
        assert self.look is not None
        return self.look.axes[self._axis]

    @property
    def moves(self) -> bool:
        """True if the axis moves or is about to."""
        return self.look is not None and self.axis.moves

    @property
    def position_steps(self) -> int:
        """The record's raw position."""
        return self.axis.position_steps + self.offset_steps

    @property
    def lost_text(self) -> str:
        """What is to be done about a position that is not known."""
        return (
            f"board {self._unit} was reset: the position of axis {self._axis} is not "
            f"known; home it, or set its position"
        )

    def load(self, position_steps: int) -> None:
        """Make a position that of the motor where it is."""
        self._count_from(position_steps)
        self.lost = False

    def homed(self) -> None:
        """Take that a homing has set the board's register."""
        self.offset_steps, self.lost = 0, False

    def lose(self, shown_steps: int) -> None:
        """Take that the board was reset: the position shown stays, and is not to be trusted."""
        self._count_from(shown_steps)
        self.lost = True

    def _count_from(self, position_steps: int) -> None:
        self.offset_steps = set_position(position_steps, self.axis.position_steps)
