# SPDX-License-Identifier: MIT
"""What the commands share that run lines on boards: their records, a file of them, what is said."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TypedDict

import click

from pixstep.board import recordfiles, recording
from pixstep.board.logs import Row
from pixstep.board.recording import Recorder
from pixstep.board.run import Lines
from pixstep.cli.command import OutFile
from pixstep.cli.options import say, teller
from pixstep.cli.quantities import Decorated
from pixstep.errors import UserError


class _RecordFile(OutFile):
    """A file of records; its name says the form."""

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> Path:
        """Refuse a name that says no form."""
        path: Path = super().convert(value, param, ctx)  # type: ignore[arg-type]
        recordfiles.refuse(path)
        return path


def _not_both(ctx: click.Context, param: click.Parameter, value: object) -> object:
    """Refuse a file of records together with the option that reads none."""
    said = ctx.params | {param.name or "": value}
    if said.get("record_file") and said.get("record") is False:
        raise UserError("--records and --no-records: a file of records needs them read")
    return value


_OPTIONS = (
    click.option(
        "--records", "record_file", type=_RecordFile(), metavar="FILE", callback=_not_both,
        help="Write the per-pixel records into a file: .csv or .parquet.",
    ),
    click.option(
        "--no-records", "record", is_flag=True, default=True, flag_value=False,
        callback=_not_both,
        help="Do not read the records along: they cost the fastest lines time.",
    ),
)  # fmt: skip


def record_options(command: Decorated) -> Decorated:
    """Give a command the options of records."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


class RecordFacts(TypedDict):
    """What was read of an axis' records, for JSON."""

    read: int
    missed: int
    every_px: int
    max_difference_steps: int


@dataclass
class Records:
    """The records of a command's lines."""

    path: Path | None
    rows: recordfiles.Rows | None
    recorders: dict[int, Recorder] = field(default_factory=dict)
    worst: dict[tuple[int, int], int] = field(default_factory=dict)

    def take(self, unit: int, row: Row) -> None:
        """Take a record of a board."""
        difference = abs(row.record.actual_steps - row.record.expected_steps)
        place = (unit, row.axis)
        self.worst[place] = max(self.worst.get(place, 0), difference)
        if self.rows:
            self.rows.take(unit, row)

    def of(self, unit: int, axis: int) -> RecordFacts | None:
        """Return what was read of an axis; None if its records were not read."""
        recorder = self.recorders.get(unit)
        if recorder is None or axis not in recorder.rows:
            return None
        return {
            "read": recorder.rows[axis],
            "missed": recorder.missed[axis],
            "every_px": recorder.every,
            "max_difference_steps": self.worst.get((unit, axis), 0),
        }

    @property
    def total(self) -> int:
        """How many records were read."""
        return sum(sum(recorder.rows.values()) for recorder in self.recorders.values())

    @property
    def missed(self) -> int:
        """How many were overwritten before they were read."""
        return sum(sum(recorder.missed.values()) for recorder in self.recorders.values())

    def say(self) -> None:
        """Say of each board what is not in its records."""
        for unit, recorder in self.recorders.items():
            if recorder.every > 1:
                say((
                    f"board {unit}: records of every {recorder.every} pixels and of every "
                    f"deviation: more of them cannot be read in time (setting record_every)",
                ))  # fmt: skip
            for axis, count in recorder.missed.items():
                if count:
                    say((
                        f"board {unit} axis {axis}: {count} records were overwritten before they "
                        f"were read",
                    ))  # fmt: skip


@contextlib.contextmanager
def recorded(
    group: list[Lines],
    path: Path | None,
    *,
    wanted: bool = True,
    streamed: bool = True,
    queued: bool = False,
) -> Iterator[Records]:
    """Read the records of lines along while they are followed, into a file if one is named.

    See `recording.recorded`. The file is written whatever ends the lines, and what it does not hold
    is said.
    """
    with contextlib.ExitStack() as stack:
        rows = stack.enter_context(recordfiles.writing(path)) if path else None
        found = Records(path, rows)
        for lines in group if wanted or path else ():
            unit = lines.board.unit
            take = partial(found.take, unit)
            one = stack.enter_context(
                recording.recorded(lines, take, streamed=streamed, queued=queued)
            )
            if one:
                found.recorders[unit] = one
        yield found
        if path:
            found.say()


def exit_status(found: Records, *, echo: bool) -> int:
    """Say what a file of records holds; return 1 if it does not hold all that the boards made."""
    if found.path is None:
        return 0
    if echo:
        missed = f"{found.missed} missed" if found.missed else "none missed"
        teller(found.path)(f"{found.path}: {found.total} records, {missed}")
    return int(found.missed > 0)
