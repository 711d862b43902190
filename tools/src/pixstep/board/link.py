# SPDX-License-Identifier: MIT
"""A line with boards on it, as whoever talks to them sees it: a serial port, or the simulator."""

from typing import Protocol

from pixstep.board.device import Board
from pixstep.board.transport import FittingClient
from pixstep.board.world import World


class Link(Protocol):
    """What requests go through, and the time that the boards live in."""

    @property
    def modbus(self) -> FittingClient:
        """The client of the line."""

    @property
    def world(self) -> World:
        """The boards' time."""

    @property
    def port(self) -> str:
        """The line's name, for messages."""

    def board(self, unit: int = 1) -> Board:
        """Return a unit of the line; nothing is asked of it yet."""

    def close(self) -> None:
        """Give the line back."""
