# SPDX-License-Identifier: MIT
"""A press of two simulated boards with three motors, and a job for it."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

from pixstep import formats, natives, ops
from pixstep.jobs.job import Job
from pixstep.operations.result import Result
from pixstep.simulation.simulated_board import SimLink
from pixstep.simulation.simulator import SimOptions

PIXEL_HZ = Fraction(100)
BOARDS = ("mega", "uno")
# Where each motor is: board and axis, from 0.
PLACES = {"M39": (0, 0), "M40": (0, 1), "M41": (1, 0)}
PITCH = 12
_SPEED, _BACKLASH, _TURN = 200, 50, 120
_MACHINE = f"""\
clock = {{ pixel = "RATE Hz", divider = 1, sync = "SYNC" }}
line.lead_in = 4

[boards.main]
kind = "mega"
unit = 1

[boards.side]
kind = "uno"
unit = 2

[motors.M39]
board = "main"
axis = 0
kind = "smooth"
backlash = "{_BACKLASH} steps"
profiles = {{ line = "line.PRN", move = "move.csv", home = "home-M39.csv" }}

[motors.M40]
board = "main"
axis = 1
kind = "plain"
profiles = {{ line = "turn.PRN", move = "move.csv", home = "home-M40.csv" }}

[motors.M41]
board = "side"
axis = 0
kind = "plain"
profiles = {{ move = "step.csv", home = "home-M41.csv" }}
"""
_PROFILES = {
    "move.csv": [4, 12, 20, 28],
    "step.csv": [2, 4, 6],
}
_HOMING = {"M39": [4, 12, 24, 40], "M40": [2, 4, 6, 8], "M41": [2, 4, 6, 8]}
_HOME = formats.ProfileHeader("Thu Nov 26 12:00:00 2026", "home", 1, 4, 0, str(PIXEL_HZ))


@dataclass
class Press:
    """A folder with machine file and job, and how the boards are simulated."""

    folder: Path
    job: Job
    hz: Fraction = PIXEL_HZ
    options: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def make(
        cls, folder: Path, lines: int, pixels: int = 20, sync: str = "lock",
        starts: Mapping[str, int] | None = None, pixel_hz: Fraction = PIXEL_HZ,
    ) -> Press:  # fmt: skip
        """Write a machine and a job of so many lines; `starts` is where motors begin."""
        formats.write_prn(folder / "line.PRN", [20, 60, 120, 180, _SPEED])
        formats.write_prn(folder / "turn.PRN", [4, 12, 20, 28])
        for name, counts in _PROFILES.items():
            formats.write_csv(folder / name, counts)
        for name, counts in _HOMING.items():
            formats.write_csv(folder / f"home-{name}.csv", counts, _HOME)
        machine = folder / "machine.toml"
        machine.write_text(_MACHINE.replace("SYNC", sync).replace("RATE", str(pixel_hz)))
        path = folder / "print.pxjob"
        ops.job_make(
            image_size=f"{pixels}x{lines}", scan=f"M39={_SPEED}", step=f"M41={PITCH}",
            turn=f"M40={_TURN}", output=path, machine=machine,
            start=tuple(f"{name}={at}" for name, at in (starts or {}).items()),
        )  # fmt: skip
        return cls(folder, Job.read(path), pixel_hz)

    @property
    def machine(self) -> Path:
        """The machine file."""
        return self.folder / "machine.toml"

    @property
    def edges(self) -> Path:
        """The list of edges on the pins."""
        return self.folder / "edges.csv"

    @contextlib.contextmanager
    def bus(self, **more: Any) -> Iterator[SimLink]:
        """Yield the bus with both boards."""
        boards = [(name, natives.image(name)) for name in BOARDS]
        options = {"edges": self.edges, **self.options, **more}
        with SimLink(SimOptions(boards, self.hz, **options)) as link:
            yield link

    def run(self, link: SimLink, run: Path, **more: Any) -> Result:
        """Print the job."""
        done: Result = ops.job_run(
            self.job.path, folder=run, machine=self.machine, link=link, accept_amber=True, **more
        )
        return done

    def resume(self, link: SimLink, run: Path, **more: Any) -> Result:
        """Go on with a run."""
        done: Result = ops.job_resume(
            run, machine=self.machine, link=link, accept_amber=True, **more
        )
        return done

    def steps(self, line: int, motor: str = "M39") -> int:
        """Return the edges that a motor makes in a line."""
        return int(self.job.line(line)[motor].total_steps)
