# SPDX-License-Identifier: MIT
"""The boards of a job as they are spoken to: each with its motors and their axes.

The register `tag` of a board says whose run it is in; a reset makes it 0. Beside it a board has a
time for which its bus may be silent. Where no line needs the host while it moves, that time is
longer than two lines last: when the host dies, the motors of all boards make what is queued, and
stop at the end of the same line.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from pixstep.board import boards, run, settings, upload
from pixstep.board.device import Device
from pixstep.board.link import Link
from pixstep.board.run import LinesOfBoard
from pixstep.errors import UserError
from pixstep.jobs.account import JobAxis
from pixstep.jobs.job import Job
from pixstep.jobs.run_log import Base
from pixstep.machine.files import MachineFile

TAG, SILENCE = "tag", "bus_timeout_ms"
NO_TAG = 0  # a board's tag after a reset, and when it is in no run
_MOST = 0xFFFF
_MOST_MS = 60_000
_SPARE_MS = 1000


def new_tag() -> int:
    """Return the tag of a run on a board."""
    return 1 + secrets.randbelow(_MOST)


def silence_ms(stored_ms: int, two_lines_s: float, *, safe: bool) -> int:
    """Return how long the bus of a board may be silent while it runs; 0 is for ever."""
    if not (stored_ms and safe):
        return stored_ms
    return min(max(stored_ms, int(1000 * two_lines_s) + _SPARE_MS), _MOST_MS)


def hold(board: Device, name: str, value: int) -> None:
    """Let a board keep a tag or a time, until its next reset."""
    if board.setting(name) != value:
        board.write_setting(name, value)


def has_lost_tag(board: Device, tag: int) -> bool:
    """Return whether a board has lost its tag, by a reset or somebody else's order."""
    return board.setting(TAG) != tag


@dataclass
class Station:
    """A board of a job: its name in the machine file, its motors with their axes."""

    name: str
    board: Device
    motors: Mapping[str, int]
    link: Link
    bases: Mapping[str, Base] = field(default_factory=dict)
    lines: LinesOfBoard = field(init=False)

    def __post_init__(self) -> None:
        self.lines = LinesOfBoard(self.board, sorted(self.motors.values()))

    def look(self) -> list[JobAxis]:
        """Read the registers of the axes, in one request."""
        run.look(self.lines)
        return self.axes()

    def axes(self) -> list[JobAxis]:
        """Return the axes as they were seen last."""
        seen = self.lines.seen
        return [JobAxis(name, self.bases[name], seen[axis]) for name, axis in self.motors.items()]

    def rebase(self) -> None:
        """Let counters and positions of a chain of lines begin here."""
        run.look(self.lines)
        self.bases = {
            name: Base(
                self.board.unit, axis, *(
                    self.lines.seen[axis][key]
                    for key in ("lines_done", "next_block", "position_steps")
                ),
            )
            for name, axis in self.motors.items()
        }  # fmt: skip

    @property
    def positions(self) -> dict[str, int]:
        """The positions of the motors as they were seen last."""
        return {name: self.lines.seen[axis]["position_steps"] for name, axis in self.motors.items()}


def of_job(job: Job, machine: MachineFile, bus_of: Callable[[str], Link]) -> list[Station]:
    """Return the boards of a job; `bus_of` opens the bus of one by its name.

    Raises UserError for boards on several buses: nobody could start them together.
    """
    motors: dict[str, dict[str, int]] = {}
    for name in job.motors:
        motor = machine[name]
        motors.setdefault(machine.board_name(motor), {})[name] = motor.axis
    links = {name: bus_of(name) for name in motors}
    if len({id(link) for link in links.values()}) > 1:
        raise UserError(
            f"{machine.path}: the job's boards are on several ports ({', '.join(motors)}): boards "
            f"that begin together are on one bus"
        )
    return [
        Station(name, links[name].board(machine.boards[name].unit), axes, links[name])
        for name, axes in motors.items()
    ]


def bases_of(found: list[Station]) -> dict[str, dict[str, int]]:
    """Return where counters and positions of all motors begin, as the log has it."""
    return {name: vars(base) for one in found for name, base in one.bases.items()}


def set_clock(stations: list[Station], machine: MachineFile) -> None:
    """Set the boards' pixel clock as the machine file has it; one without a gate is not gated."""
    clock = machine.clock
    for station in stations:
        gate = clock.gate_edges or (0 if station.board.has(boards.GATE_FEATURE) else None)
        settings.set_clock(
            station.board, machine.clock_hz, clock.sync, clock.edges, gate,
            machine.boards[station.name].clock_out_hz,
        )  # fmt: skip


def ready(stations: list[Station]) -> None:
    """Enable the drivers. Raises BoardError for an axis that has a line, or moves."""
    for station in stations:
        axes = station.lines.axes
        upload.require_idle(station.board, axes)
        run.command(station.board, "enable", axes)
