# SPDX-License-Identifier: MIT
"""How quick motor records are: `pixstep ioc` with simulated boards in real time, on this computer.

A client on the loopback writes; the simulator notes each STEP edge with its time.
"""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pixstep.ioc import server, settings
from pixstep.ioc.saved import Saved
from pixstep.machine import files
from pixstep.motor_drive import BusDrives
from pixstep.operations import ioc
from pixstep.simulation.logs import read_edges
from pixstep_trials.ca_wire import HOST, CaWire

_HEAD = """
[clock]
pixel = "100 Hz"

[line]
motor = "m0"

[boards.main]
kind = "mega"
"""
_BOARD = """
[boards.other]
kind = "mega"
unit = 2
"""
_MOTOR = """
[motors.m{number}]
axis = {axis}
board = "{board}"
kind = "plain"
limits = {{ max_speed = "2000 steps/s", max_acceleration = "20000 steps/s2" }}
"""
_ANCHOR = "5 to 20 ms with the record in C and its own simulated motor"
_TRIES, _SPAN_S = 30, 8.0


@dataclass(frozen=True)
class Figures:
    """Times in seconds, shares of one processor."""

    first_edge_s: list[float]
    nothing_s: list[float]
    rest_share: float
    moving_share: float

    def lines(self) -> Iterator[str]:
        """Yield what there is to print."""
        yield f"put to first STEP edge: {_spread(self.first_edge_s)} ({_ANCHOR})"
        yield f"a move of nothing, put to its completion: {_spread(self.nothing_s)}"
        yield (
            f"8 axes on 2 boards: {100 * self.rest_share:.0f} % of a processor at rest, "
            f"{100 * self.moving_share:.0f} % while all move"
        )


def _spread(times_s: list[float]) -> str:
    low, high = min(times_s), max(times_s)
    middle = statistics.median(times_s)
    return f"median {1000 * middle:.1f} ms, {1000 * low:.1f} to {1000 * high:.1f} ms"


def measure() -> Figures:
    """Measure on this computer; half a minute."""
    with tempfile.TemporaryDirectory() as folder:
        edges = Path(folder) / "edges.csv"
        with _served(1, edges) as (wire, drives):
            began_s = [_one_move(wire, drives, 20.0 * (1 + k % 2)) for k in range(_TRIES)]
            nothing_s = [_timed(wire, "m0", wire.value("m0")) for _ in range(_TRIES)]
        steps_s = read_edges(edges).axis(0, 0).rising / 16e6
        first_edge_s = [float(steps_s[steps_s > one][0]) - one for one in began_s]
        with _served(8, Path(folder) / "more.csv") as (wire, _):
            rest = _share()
            puts = [wire.begin(f"m{k}", 1e6) for k in range(8)]
            wire.listen(1.0)
            moving = _share()
            for k in range(8):
                wire.begin(f"m{k}.STOP", 1, wait=False)
            for put in puts:
                wire.ended(put)
    return Figures(first_edge_s, nothing_s, rest, moving)


def _one_move(wire: CaWire, drives: BusDrives, distance: float) -> float:
    """Move, and return the boards' time of the put."""
    target = wire.value("m0.RBV") + distance
    wire.listen(0.05)
    began_s = drives.now_s()
    wire.put("m0", target)
    return began_s


def _timed(wire: CaWire, name: str, value: float) -> float:
    began_s = time.perf_counter()
    wire.put(name, value)
    return time.perf_counter() - began_s


def _share() -> float:
    """Return the share of a processor that this process takes, the simulator not included."""
    began_s, used_s = time.monotonic(), time.process_time()
    time.sleep(_SPAN_S)
    return (time.process_time() - used_s) / (time.monotonic() - began_s)


class _NotedPort:
    """The log: what is wanted of it is the port."""

    def __init__(self) -> None:
        self.tcp = 0

    def tell(self, event: str, **facts: Any) -> None:
        """Keep the port."""
        if event == "serving":
            self.tcp = facts["tcp"]

    def close(self) -> None:
        """Keep what was told."""


@contextmanager
def _served(motors: int, edges: Path) -> Iterator[tuple[CaWire, BusDrives]]:
    """Yield a client of a server with so many motors, and their drives."""
    rows = [
        _MOTOR.format(number=k, axis=k % 4, board="main" if k < 4 else "other")
        for k in range(motors)
    ]
    machine = files.parse("".join([_HEAD, _BOARD if motors > 4 else "", *rows]))
    os.environ |= {
        "EPICS_CAS_INTF_ADDR_LIST": HOST,
        "EPICS_CAS_AUTO_BEACON_ADDR_LIST": "NO",
        "EPICS_CAS_BEACON_ADDR_LIST": HOST,
    }
    log = _NotedPort()
    with ioc.simulated(machine, edges) as drives:
        made = [
            server.MotorSpec(name, settings.fields_of(machine, motor), drives[name])
            for name, motor in machine.motors.items()
        ]
        found = server.RecordServer(made, "", Saved(None), log)
        try:
            found.start()
            wire = CaWire(log.tcp)
            yield wire, drives
            wire.close()
        finally:
            found.close()
