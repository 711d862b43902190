# SPDX-License-Identifier: MIT
"""Looks at the boards of a bus, again and again, whatever becomes of the bus meanwhile.

A bus is asked for by its port or its server once, by whoever begins; what is lost later comes back
by itself. The port is never opened again here, which might reset a board that moves.

Which boards the page of `pixstep watch --web` shows: of a run, a port or a machine file.

What an axis has done while it was watched: its speed, and where it was in its line.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pixstep.board import snapshot
from pixstep.board.device import Device, Identity
from pixstep.board.errors import BoardError
from pixstep.board.link import Link, SerialLink
from pixstep.board.port import BAUD, Port
from pixstep.board.snapshot import Snapshot
from pixstep.errors import UserError
from pixstep.server import remote

if TYPE_CHECKING:
    from pixstep.machine.model import MachineTables


def spots_of(machine: MachineTables, port: str, boards: Iterable[str], served: bool) -> list[Spot]:
    """Return some boards of a machine, those of a port together; `port` is instead of the file's.

    A board without a port is left out.
    """
    found: dict[str, tuple[Port, list[int]]] = {}
    for name in boards:
        board = machine.boards[name]
        place = port or board.port
        if place:
            made = Port(place, board.baud or BAUD, board.parity)
            found.setdefault(place, (made, []))[1].append(board.unit)
    return [
        Spot(made, tuple(dict.fromkeys(units)), names_on(machine, place), served)
        for place, (made, units) in found.items()
    ]


def names_on(machine: MachineTables | None, port: str) -> dict[tuple[int, int], AxisName]:
    """Return what a machine file calls axes of the boards on a port."""
    found = {}
    for motor in machine.motors.values() if machine else ():
        assert machine is not None
        board = machine.boards[machine.board_name(motor)]
        if board.port in (None, port):
            scale = motor.steps_per_unit
            about = (scale.length, float(scale.steps_per_unit)) if scale else ()
            found[board.unit, motor.axis] = AxisName(motor.name, *about)
    return found


_LOOKS = 2  # over which a speed is taken
_KEPT = 600  # speeds; at four a second those of two minutes and a half
_MOST = 1200  # places of a line: of a longer one every second place is let go, again and again


class Trail:
    """The speeds of an axis, and its places in the newest line that it was seen in.

    `line` counts the lines that were seen: with another number the places begin again.
    """

    def __init__(self) -> None:
        self.line = 0
        self.speed: float | None = None  # steps a second
        self._speeds: deque[tuple[float, float]] = deque(maxlen=_KEPT)
        self._places: list[tuple[int, int]] = []  # pixel and position
        self._last: deque[tuple[float, Mapping[str, int]]] = deque(maxlen=_LOOKS)

    def add(self, time_s: float, axis: Mapping[str, int]) -> None:
        """Add the registers of the axis as they were at a time."""
        pixel, position = axis["pixel"], axis["position_steps"]
        if not self._last:
            self._begin()
        else:
            before = self._last[-1][1]
            if pixel < before["pixel"] or axis["lines_done"] < before["lines_done"]:
                self._begin()
            first_s, first = self._last[0]
            if time_s > first_s:
                self.speed = (position - first["position_steps"]) / (time_s - first_s)
                self._speeds.append((round(time_s, 3), round(self.speed, 2)))
        if not self._places or self._places[-1] != (pixel, position):
            self._places.append((pixel, position))
        if len(self._places) > _MOST:
            del self._places[1:-1:2]
        self._last.append((time_s, axis))

    def lose(self) -> None:
        """Forget how it was last: a board that comes back may have been reset."""
        self.speed = None
        self._last.clear()

    def as_json(self) -> dict[str, Any]:
        """Return all that was seen, as plain data."""
        return {"line": self.line, "places": self._places[:], "speeds": list(self._speeds)}

    def _begin(self) -> None:
        self.line += 1
        self._places.clear()


MOST_S = 1.0  # between two looks: a board that nobody asks anything takes its host for dead
_RETRIES = 1  # of a request: the page is to know soon that a board is silent
_AGAIN_S = 1.0  # until a server is looked for again


@dataclass(frozen=True)
class AxisName:
    """What a machine file calls an axis, and how many steps are one of its units."""

    motor: str
    unit: str = "steps"
    steps_per_unit: float = 1.0


@dataclass(frozen=True)
class Spot:
    """Boards on a port, and the names of their axes by address and axis.

    One that is `served` is asked through the port's server alone.
    """

    port: Port
    units: tuple[int, ...]
    names: Mapping[tuple[int, int], AxisName] = field(default_factory=dict)
    served: bool = False


@dataclass
class Seen:
    """A board as it was seen last; `trouble` says why it is not seen now."""

    unit: int
    board: Device | None = None
    who: Identity | None = None
    now: Snapshot | None = None
    before: Snapshot | None = None
    since_s: float = field(default_factory=time.monotonic)  # of its newest figures
    trouble: str = ""
    trails: dict[int, Trail] = field(default_factory=dict)

    @property
    def age_s(self) -> float:
        """How old its figures are."""
        return time.monotonic() - self.since_s


class Eye:
    """Looks at the boards of a spot, in a thread of its own; `seen` are those, by address."""

    def __init__(
        self, spot: Spot, link: Link | None, interval_s: float, tell: Callable[[], None]
    ) -> None:
        self.spot, self._link, self._tell = spot, link, tell
        self._interval_s = min(interval_s, MOST_S)
        self.seen = {unit: Seen(unit) for unit in spot.units}
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look_on, name="eye", daemon=True)

    def begin(self) -> None:
        """Begin to look."""
        self._thread.start()

    def close(self) -> None:
        """Look no more."""
        self._over.set()
        self._thread.join()

    def look(self) -> None:
        """Look at all boards once."""
        for seen in self.seen.values():
            if self._link:
                _look(self._link, seen)
            self._tell()

    def stop(self) -> str:
        """Stop all boards of the bus by a broadcast; return in words what was done."""
        name = self.spot.port.name
        try:
            client = remote.find(self.spot.port)  # past the requests of this process
            link = SerialLink(client, name) if client else self._link
            if link is None:
                return f"{name}: NOT STOPPED: no server has it"
            link.board(1).stop_all()
            if client:
                client.close()
        except (BoardError, UserError) as error:
            return f"{name}: NOT STOPPED: {error}"
        return f"{name}: stop sent to all boards"

    def _look_on(self) -> None:
        while not self._over.is_set():
            self._link = self._link or self._served()
            self.look()
            self._over.wait(self._interval_s if self._link else _AGAIN_S)
        if self.spot.served and self._link:
            self._link.close()

    def _served(self) -> Link | None:
        """Return the bus through its server; without one, say so of every board."""
        port, said = self.spot.port, ""
        try:
            client = remote.find(port)
            if client:
                return SerialLink(client, port.name)
            said = f"no server has {port.name}: its boards are seen through `pixstep serve` alone"
        except (BoardError, UserError) as error:
            said = str(error)
        for seen in self.seen.values():
            seen.trouble = said
        return None


def _look(link: Link, seen: Seen) -> None:
    """Look at a board; what keeps it from being seen is noted."""
    try:
        with link.modbus.patient(retries=_RETRIES):
            if seen.board is None or seen.who is None or seen.trouble:
                seen.board = link.board(seen.unit)
                seen.who = seen.board.who()
            axes = seen.board.axes(seen.who.axis_count)
            now_s = link.world.now_s()  # speeds by the time of the reply are steady on a busy bus
            _take(seen, snapshot.take(seen.board, seen.who, now_s, axes))
    except (BoardError, UserError) as error:
        for trail in seen.trails.values():
            trail.lose()
        seen.trouble, seen.before = str(error), None


def _take(seen: Seen, found: Snapshot) -> None:
    for axis, registers in enumerate(found.axes):
        seen.trails.setdefault(axis, Trail()).add(found.time_s, registers)
    seen.before, seen.now = (None if seen.trouble else seen.now), found
    seen.since_s, seen.trouble = time.monotonic(), ""
