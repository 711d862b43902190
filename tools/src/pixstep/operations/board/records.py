# SPDX-License-Identifier: MIT
"""The records of lines that an operation follows: read along, in a file, what is said of them."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TypedDict

from pixstep.board import recording
from pixstep.board.recording import Recorder, Row
from pixstep.board.run import Lines
from pixstep.errors import FINE, NEGATIVE
from pixstep.operations.asked import AskedError
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import OutFile
from pixstep.operations.request import Request, option, shared_fields, unless
from pixstep.operations.result import Data, Result


class _RecordFile(OutFile):
    """A file of records; its name says the form."""

    def judge(self, value: Any) -> Path:
        """Refuse a name that says no form."""
        path = super().judge(value)
        recording.refuse_name(path)
        return path


class ReadRecords(TypedDict):
    """What was read of an axis' records."""

    read: int
    missed: int
    every_px: int
    max_difference_steps: int


@shared_fields
class RecordFields(Request):
    """Whether records are read along, and where they go."""

    record_file: Path | None = option(
        _RecordFile(), "Write the per-pixel records into a file: .csv or .parquet.", "--records",
        shown="FILE",
    )  # fmt: skip
    record: bool = unless(
        "Do not read the records along: they cost the fastest lines time.", "--no-records"
    )

    def refuse_file(self, *, followed: bool = True, instead: str = "") -> None:
        """Refuse a file of records that would not be read."""
        if self.record_file and not self.record:
            raise AskedError("{record_file} and {record}: a file of records needs them read")
        if self.record_file and not followed:
            raise AskedError("{record_file}: records are read while lines run: " + instead)


@dataclass
class Records:
    """The records of an operation's lines."""

    path: Path | None
    rows: recording.Rows | None
    recorders: dict[int, Recorder] = field(default_factory=dict)
    worst: dict[tuple[int, int], int] = field(default_factory=dict)

    def take(self, unit: int, row: Row) -> None:
        """Take a record of a board."""
        difference = abs(row.record.actual_steps - row.record.expected_steps)
        place = (unit, row.axis)
        self.worst[place] = max(self.worst.get(place, 0), difference)
        if self.rows:
            self.rows.take(unit, row)

    def of(self, unit: int, axis: int) -> ReadRecords | None:
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

    def result(self, data: Data, texts: list[str]) -> Result:
        """Return the result of the lines; negative if a file lacks what the boards made."""
        if self.path is None:
            return Result(data, "\n".join(texts))
        total = sum(sum(recorder.rows.values()) for recorder in self.recorders.values())
        lost = sum(sum(recorder.missed.values()) for recorder in self.recorders.values())
        missed = f"{lost} missed" if lost else "none missed"
        text = "\n".join([*texts, f"{self.path}: {total} records, {missed}"])
        return Result(data, text, NEGATIVE if lost else FINE)

    def notes(self) -> Iterator[str]:
        """Yield of each board what is not in its records."""
        for unit, recorder in self.recorders.items():
            if recorder.every > 1:
                yield (
                    f"board {unit}: records of every {recorder.every} pixels and of every "
                    f"deviation: more of them cannot be read in time (setting record_every)"
                )
            for axis, count in recorder.missed.items():
                if count:
                    yield (
                        f"board {unit} axis {axis}: {count} records were overwritten before they "
                        f"were read"
                    )


@contextlib.contextmanager
def recorded(
    desk: Desk,
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
        rows = stack.enter_context(recording.writing(path)) if path else None
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
            desk.say(found.notes())
