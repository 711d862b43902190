# SPDX-License-Identifier: MIT
"""Servers of motor records for tests, in this process: with ideal steppers, and a client."""

import contextlib
import socket
import threading
import time

from ideal_drive import IdealDrive, Stepper
from pixstep.ioc.saved import Saved
from pixstep.ioc.server import MotorSpec, RecordServer
from pixstep_trials.ca_wire import HOST, CaWire

FIELDS = {
    "EGU": "mm", "PREC": 3, "MRES": 0.01, "VELO": 20.0, "VMAX": 40.0, "ACCL": 0.1,
    "BVEL": 10.0, "BACC": 0.1, "DHLM": 50.0, "DLLM": -50.0, "DESC": "a stage", "OUT": "@ideal",
}  # fmt: skip


def free_port():
    """Return a port that nobody has now."""
    with socket.socket() as one:
        one.bind((HOST, 0))
        return one.getsockname()[1]


def loopback(port):
    """Return the variables by which clients and servers meet on this machine alone."""
    return {
        "EPICS_CA_ADDR_LIST": HOST,
        "EPICS_CA_AUTO_ADDR_LIST": "NO",
        "EPICS_CA_SERVER_PORT": str(port),
        "EPICS_CA_REPEATER_PORT": str(port + 1),
        "EPICS_CAS_INTF_ADDR_LIST": HOST,
        "EPICS_CAS_AUTO_BEACON_ADDR_LIST": "NO",
        "EPICS_CAS_BEACON_ADDR_LIST": HOST,
        "EPICS_CAS_BEACON_PORT": str(port + 1),
    }


class Noted:
    """A log that keeps what it is told."""

    def __init__(self):
        self.lines = []
        self.told = threading.Condition()

    def tell(self, event, **facts):
        """Keep an event."""
        with self.told:
            self.lines.append((event, facts))
            self.told.notify_all()

    def facts(self, event):
        """Return the facts of each event of a kind."""
        return [facts for one, facts in self.lines if one == event]

    def wait(self, event, seconds=5.0):
        """Wait for an event."""
        with self.told:
            assert self.told.wait_for(lambda: self.facts(event), seconds), (event, self.lines)


class Bench:
    """A server with ideal steppers by record's name."""

    def __init__(self, monkeypatch, *, state=None, prefix="T:", drives=None, fields=None):
        for name, value in loopback(free_port()).items():
            monkeypatch.setenv(name, value)
        self.drives = drives or {"T:m": IdealDrive(Stepper(home=1e8))}
        self.log = Noted()
        fields = fields or {}
        motors = [
            MotorSpec(name, FIELDS | fields.get(name, {}), drive)
            for name, drive in self.drives.items()
        ]
        self.server = RecordServer(motors, prefix, Saved(state), self.log)
        self.wires = []

    def start(self):
        """Begin to serve, and return a client."""
        self.server.start()
        return self.wire()

    def wire(self, host="test"):
        """Return another client."""
        (facts,) = self.log.facts("serving")
        self.wires.append(CaWire(facts["tcp"], host))
        return self.wires[-1]

    def close(self):
        """End."""
        for one in self.wires:
            one.close()
        self.server.close()


@contextlib.contextmanager
def served(monkeypatch, **more):
    """Yield a server that runs, and a client of it."""
    bench = Bench(monkeypatch, **more)
    try:
        yield bench, bench.start()
    finally:
        bench.close()


def until(found, seconds=5.0):
    """Wait until something is true."""
    end_s = time.monotonic() + seconds
    while not found():
        assert time.monotonic() < end_s
        time.sleep(0.01)
