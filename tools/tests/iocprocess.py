# SPDX-License-Identifier: MIT
"""`pixstep ioc` in a process of its own, and unmodified clients of it in others."""

import json
import os
import subprocess
import sys
from pathlib import Path

from iocbench import free_port, loopback, until
from pixstep import natives
from pixstep_trials.ca_wire import CaWire

HERE = Path(__file__).parent
MACHINE = """
[clock]
pixel = "30 Hz"

[epics]
prefix = "T:"

[boards.main]
kind = "mega"

[motors.m1]
axis = 0
kind = "smooth"
steps_per_unit = "400 steps/mm"
backlash = "8 steps"
limits = { max_speed = "5 mm/s", max_acceleration = "50 mm/s2" }
epics = { fields = { DHLM = 100, DLLM = -100 } }

[motors.m2]
axis = 1
kind = "plain"
direction = "-"
epics.name = "second"
"""


class Command:
    """`pixstep ioc` in a process of its own: with ideal steppers, or simulated boards."""

    def __init__(self, folder, *words, ideal=True, program=()):
        self.folder, self.log = folder, folder / "log"
        self.env = os.environ | loopback(free_port())
        words = words if ideal else ("--simulate", *words)
        program = program or [HERE / ("ideal_ioc.py" if ideal else "sim_ioc.py"), folder]
        with self.log.open("wb") as out:
            self.process = subprocess.Popen(
                [sys.executable, *program, "ioc", "--json", *words],
                cwd=folder, stdout=out, stderr=subprocess.STDOUT, env=self.env,
            )  # fmt: skip

    def events(self, name):
        """Return the events of a name that the log has."""
        told = [row for row in self.log.read_text().splitlines() if row.startswith("{")]
        return [row for row in map(json.loads, told) if row.get("event") == name]

    def wire(self):
        """Return a client, as soon as it can connect."""
        until(lambda: self.events("serving"), 20)
        return CaWire(self.events("serving")[0]["tcp"])

    def end(self, number):
        """End it by a signal, and return its exit status."""
        self.process.send_signal(number)
        return self.process.wait(20)

    def client(self, program, *words, seconds=120):
        """Run a client by the environment of clients; return the rows of JSON that it prints."""
        done = self.run_client(HERE / "with_clients" / program, *words, seconds=seconds)
        assert done.returncode == 0, done.stdout + done.stderr
        return [json.loads(row) for row in done.stdout.splitlines() if row.startswith("[")]

    def run_client(self, *words, seconds=120):
        """Run Python in the environment of clients.

        Its streams are files: a repeater of Channel Access that a client starts keeps them open.
        """
        python = natives.root() / "build" / "clients" / "bin" / "python"
        assert python.exists(), f"{python} is not there: tools/setup"
        out, errors = self.folder / "client.out", self.folder / "client.err"
        env = {key: value for key, value in self.env.items() if not key.startswith("PYTHON")}
        with out.open("wb") as told, errors.open("wb") as complained:
            done = subprocess.run(
                [python, *map(str, words)], cwd=self.folder, env=env, stdout=told,
                stderr=complained, timeout=seconds, check=False,
            )  # fmt: skip
        texts = (path.read_text(errors="replace") for path in (out, errors))
        return subprocess.CompletedProcess(done.args, done.returncode, *texts)
