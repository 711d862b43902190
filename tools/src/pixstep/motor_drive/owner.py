# SPDX-License-Identifier: MIT
"""What the drive of a motor wants of the bus that gives it its turns."""

from typing import Protocol


class TurnGiver(Protocol):
    """The bus that gives a motor its turns."""

    def wake(self) -> None:
        """There is something to do; from any thread."""

    def now_s(self) -> float:
        """Return the boards' time."""

    @property
    def motions(self) -> int:
        """How many motions there are."""
