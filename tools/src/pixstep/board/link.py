# SPDX-License-Identifier: MIT
"""A bus with boards as whoever talks to them sees it: requests, and the time boards live in.

A serial port is one (`open_port`), the simulator another (simulation/simulated_board.py).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from pixstep.board.device import Device
from pixstep.board.modbus import Client, SerialClient
from pixstep.board.port import BOOT_S, Port

Say = Callable[[str], None]


class World(Protocol):
    """Time, as whoever waits for a board sees it."""

    def now_s(self) -> float:
        """Return seconds since any fixed instant."""

    def wait(self, seconds: float) -> None:
        """Let time pass."""


class Link(Protocol):
    """What requests go through, and the time that the boards live in."""

    @property
    def modbus(self) -> Client:
        """The client that sends requests and receives replies."""

    @property
    def world(self) -> World:
        """The boards' time."""

    @property
    def port(self) -> str:
        """The bus's name, for messages."""

    def board(self, unit: int = 1) -> Device:
        """Return a unit of the bus; nothing is asked of it yet."""

    def close(self) -> None:
        """Give the bus back."""


class WallClock:
    """The time of a real board."""

    def now_s(self) -> float:
        """Return seconds since any fixed instant."""
        return time.monotonic()

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        time.sleep(seconds)


@dataclass(frozen=True)
class SerialLink:
    """An open serial port and real time."""

    modbus: Client
    port: str
    world: World = field(default_factory=WallClock)

    def board(self, unit: int = 1) -> Device:
        """Return a unit of the bus; nothing is asked of it yet."""
        return Device(self.modbus, unit)

    def close(self) -> None:
        """Give the port back."""
        self.modbus.close()


def open_port(
    port: Port, say: Say = lambda _: None, first: Callable[[Link], None] = lambda _: None
) -> SerialLink:
    """Open a port; raises UserError saying why it cannot be opened.

    `first` is done at once. If opening the port has reset a board, the boot loader is given its
    time then: on a bus that is behind an adapter nothing was reset.
    """
    client = SerialClient(port)
    link = SerialLink(client, port.name)
    has_reset = client.connect_reset()
    first(link)
    if has_reset:
        say(
            f"opening {port.name} for the first time resets a board that is plugged in by USB: "
            f"waiting {BOOT_S:g} s for its boot loader"
        )
        link.world.wait(BOOT_S)
    return link
