# SPDX-License-Identifier: MIT
"""A line with boards, opened for one command."""

from collections.abc import Callable
from dataclasses import dataclass

from pixstep.board import transport
from pixstep.board.client import Board
from pixstep.board.port import BOOT_S, NO_PARITY, is_pty
from pixstep.board.world import WallClock, World

Say = Callable[[str], None]


@dataclass(frozen=True)
class PortOptions:
    """What a line is opened with.

    Without a parity it is even, and none on a pseudo terminal; without a time to wait for replies
    it is transport.TIMEOUT_S.
    """

    port: str
    baud: int = transport.BAUD
    parity: str | None = None
    timeout_s: float | None = None

    @property
    def real_parity(self) -> str:
        """The parity to open the port with."""
        return self.parity or (NO_PARITY if is_pty(self.port) else transport.PARITY)


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
        timeout_s=options.timeout_s or transport.TIMEOUT_S,
    )
    world = WallClock()
    if client.connect_reset():
        say(
            f"opening {options.port} for the first time resets a board that is plugged in by USB: "
            f"waiting {BOOT_S:g} s for its boot loader"
        )
        world.wait(BOOT_S)
    return Connection(client, world, options.port)
