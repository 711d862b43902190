# SPDX-License-Identifier: MIT
"""The folder of a run, NAME.pxrun: the job, the log, and what somebody asks of the run.

The job is in it as a copy, so that nothing else is needed to go on.

Per-pixel records of a run, a Parquet file a line: where each motor should have been, and was.

They are what the boards keep and this computer has read in time: `record_every` of the boards, and
pixels that were overwritten before, leave gaps. Unlike the log they are not synced.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from pixstep import atomic
from pixstep.board.state import Record
from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.jobs import run_log
from pixstep.jobs.job import Job
from pixstep.jobs.run_log import BEGIN, Event, History, RunLog
from pixstep.lazy import parquet, pyarrow

FOLDER = "parts"
FIELDS = ("pixel", "expected_steps", "actual_steps", "edge_error_ticks")


class Parts:
    """The folder of the records; lines are written once nothing more comes of them."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder / FOLDER
        with atomic.told_of(self._folder):  # here, not when the first line has been made
            self._folder.mkdir(exist_ok=True)
        self._rows: dict[int, list[tuple[str, Record]]] = {}

    def take(self, line: int, motor: str, record: Record) -> None:
        """Take a record of a motor in a line."""
        self._rows.setdefault(line, []).append((motor, record))

    def write(self, last: int) -> None:
        """Write the lines up to one."""
        for line in sorted(self._rows):
            if line <= last:
                self._write(line, self._rows.pop(line))

    def _write(self, line: int, rows: Iterable[tuple[str, Record]]) -> None:
        found = sorted(rows, key=lambda row: (row[0], row[1].pixel))
        columns = {"motor": pyarrow.array([motor for motor, _ in found], pyarrow.string())} | {
            name: pyarrow.array([getattr(record, name) for _, record in found], pyarrow.int32())
            for name in FIELDS
        }
        sink = pyarrow.BufferOutputStream()
        parquet.write_table(pyarrow.table(columns), sink, compression="zstd")
        path = self._folder / f"line-{line:06}.parquet"
        with atomic.rules(atomic.WriteRules(force=True)):
            atomic.write_bytes(path, bytes(sink.getvalue().to_pybytes()))


SUFFIX = ".pxrun"
_JOB, _PAUSE = "job.pxjob", "pause"


@dataclass(frozen=True)
class RunFolder:
    """A run's folder, which is there."""

    path: Path

    @classmethod
    def begin(cls, path: Path, job: Job) -> RunFolder:
        """Make the folder of a new run. Raises RefusedError for one that is not a new run's."""
        cls.refuse_other(path, job)
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(f"{path}: {error.strerror or error}") from None
        if not (path / _JOB).exists():
            atomic.write_bytes(path / _JOB, job.path.read_bytes())
        return cls(path)

    @staticmethod
    def refuse_other(path: Path, job: Job) -> None:
        """Refuse a folder that has a run, or anything besides what a begin that was cut short left.

        A run writes only into a folder of its own.
        """
        try:
            names = {one.name for one in path.iterdir()}
        except FileNotFoundError:
            return
        except OSError as error:
            raise UserError(f"{path}: {error.strerror or error}") from None
        if run_log.NAME in names:
            raise RefusedError(AskedText(
                "{path}: has a run already: `pixstep job resume {path}` goes on with it, {folder} "
                "names another one", path=path,
            ))  # fmt: skip
        if _JOB in names and _is_copy(path / _JOB, job):
            names.remove(_JOB)
        strange = sorted(name for name in names if not name.startswith(atomic.UNFINISHED))
        if strange:
            raise RefusedError(AskedText(
                "{path}: has {name} and no run: a run wants a folder of its own, {folder} names a "
                "new one", path=path, name=strange[0],
            ))  # fmt: skip

    @classmethod
    def of(cls, path: Path) -> RunFolder:
        """Return the folder of a run. Raises UserError if it is none."""
        log = path / run_log.NAME
        if not log.is_file():
            what = "is not a file" if log.exists() else "is not there"
            raise UserError(f"{path}: no run of a job: {run_log.NAME} {what}")
        return cls(path)

    @property
    def job_path(self) -> Path:
        """The copy of the job."""
        return self.path / _JOB

    @property
    def log_path(self) -> Path:
        """The log."""
        return self.path / run_log.NAME

    def require_job(self, job: Job) -> None:
        """Raise RefusedError unless the log says that this job was begun."""
        begun = [event.get("job") for event in self.events() if event.get("event") == BEGIN]
        if not begun:
            raise RefusedError(
                f"{self.log_path}: tells of no run that has begun: if it is lost, nobody knows "
                f"what is printed; to print again, run the job into another folder"
            )
        if job.header.id not in begun:
            raise RefusedError(f"{self.job_path}: is not the job that this run has begun with")

    def require_outside(self, output: Path) -> None:
        """Raise UserError for an output that would replace what the run itself has written."""
        kept, place = self.path.resolve(), output.resolve()
        if (
            place in (kept / run_log.NAME, kept / _JOB, kept / _PAUSE)
            or place.parent == kept / FOLDER
        ):
            raise UserError(f"{output}: is of the run itself: name another file")

    def log(self) -> RunLog:
        """Open the log to write."""
        return RunLog.open(self.log_path)

    def events(self) -> list[Event]:
        """Return what the log says."""
        return run_log.read(self.log_path)

    def history(self) -> History:
        """Return what the log says of each line."""
        return self.told(self.events())

    def told(self, events: list[Event]) -> History:
        """Return what events of the log say of each line."""
        try:
            return History.of(events)
        except (AttributeError, KeyError, TypeError, ValueError):
            raise RefusedError(
                f"{self.log_path}: has events that this pixstep does not know: the pixstep that "
                f"began the run reads them"
            ) from None

    @property
    def is_running(self) -> bool:
        """True if a process writes the log."""
        return run_log.is_written(self.log_path)

    def ask_pause(self) -> None:
        """Ask whoever runs the job to pause."""
        place = self.path / _PAUSE
        try:
            place.open("ab").close()
        except OSError as error:
            raise UserError(f"{place}: {error.strerror or error}") from None

    @property
    def pause_asked(self) -> bool:
        """True if somebody has asked for a pause."""
        return (self.path / _PAUSE).is_file()

    def forget_pause(self) -> None:
        """Take what was asked as done."""
        with contextlib.suppress(OSError):
            (self.path / _PAUSE).unlink()


def _is_copy(path: Path, job: Job) -> bool:
    """Return whether a file is the copy of a job."""
    try:
        return path.read_bytes() == job.path.read_bytes()
    except OSError:
        return False
