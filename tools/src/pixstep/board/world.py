# SPDX-License-Identifier: MIT
"""Time: the wall clock's beside a real board, the simulator's beside a simulated one."""

import time
from typing import Protocol


class World(Protocol):
    """Time, as whoever waits for a board sees it."""

    def now_s(self) -> float:
        """Return seconds since any fixed instant."""

    def wait(self, seconds: float) -> None:
        """Let time pass."""


class WallClock:
    """The time of a real board."""

    def now_s(self) -> float:
        """Return seconds since any fixed instant."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        time.sleep(seconds)
