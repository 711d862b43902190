# SPDX-License-Identifier: MIT
"""A line with boards, as whoever talks to them sees it; a serial one, opened for one command."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from pixstep.board.client import Board
from pixstep.board.port import BAUD, BOOT_S, NO_PARITY, PARITY, TIMEOUT_S, is_pty
from pixstep.board.world import WallClock, World
from pixstep.lazy import lazy

if TYPE_CHECKING:
    from pixstep.board import transport
    from pixstep.board.transport import FittingClient
else:
    transport = lazy("pixstep.board.transport")

Say = Callable[[str], None]


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


@dataclass(frozen=True)
class PortOptions:
    """What a line is opened with.

    Without a parity it is even, and none on a pseudo terminal; without a time to wait for replies
    it is TIMEOUT_S.
    """

    port: str
    baud: int = BAUD
    parity: str | None = None
    timeout_s: float | None = None

    @property
    def real_parity(self) -> str:
        """The parity to open the port with."""
        return self.parity or (NO_PARITY if is_pty(self.port) else PARITY)


@dataclass(frozen=True)
class Connection:
    """An open line and the time that its boards live in."""

    modbus: transport.FittingClient
    world: World
    port: str = "the simulator"

    def board(self, unit: int = 1) -> Board:
        """Return a unit of the line; nothing is asked of it yet."""
        return Board(self.modbus, unit)

    def close(self) -> None:
        """Give the port back."""
        self.modbus.close()


def open_port(options: PortOptions, say: Say = lambda _: None) -> Connection:
    """Open a port; raises UserError saying why it cannot be opened.

    If opening it has reset a board, the boot loader is given its time.
    """
    client = transport.serial_client(
        options.port,
        baud=options.baud,
        parity=options.real_parity,
        timeout_s=options.timeout_s or TIMEOUT_S,
    )
    world = WallClock()
    if client.connect_reset():
        say(
            f"opening {options.port} for the first time resets a board that is plugged in by USB: "
            f"waiting {BOOT_S:g} s for its boot loader"
        )
        world.wait(BOOT_S)
    return Connection(client, world, options.port)
