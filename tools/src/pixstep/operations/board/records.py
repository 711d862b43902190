# SPDX-License-Identifier: MIT
"""Records of lines and events of a board: read along, in a file, or as they come."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, TypedDict, cast

from pixstep import atomic, signals
from pixstep.board import boards, recording
from pixstep.board import registers as regs
from pixstep.board.recording import AxisLog, RecordedPixel, Recorder
from pixstep.board.run import LinesOfBoard
from pixstep.board.state import Event
from pixstep.errors import FINE, NEGATIVE
from pixstep.operations import bus
from pixstep.operations.asked import AskedError
from pixstep.operations.bus import Known, ToBoard, some_axes
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import OUTPUT, OutFile
from pixstep.operations.request import Request, flag, operation, option, shared_fields, unless
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
        "Do not read the records meanwhile: reading costs the fastest lines time.", "--no-records"
    )

    def refuse_file(self, *, followed: bool = True, instead: str = "") -> None:
        """Refuse a file of records that would not be read."""
        if self.record_file and not self.record:
            raise AskedError("{record_file} and {record}: a file of records needs them read")
        if self.record_file and not followed:
            raise AskedError("{record_file}: records are read while lines run: " + instead)


@dataclass
class RunRecords:
    """The records of an operation's lines."""

    path: Path | None
    rows: recording.RecordSink | None
    recorders: dict[int, Recorder] = field(default_factory=dict)
    worst: dict[tuple[int, int], int] = field(default_factory=dict)

    def take(self, unit: int, row: RecordedPixel) -> None:
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
    group: list[LinesOfBoard],
    path: Path | None,
    *,
    wanted: bool = True,
    streamed: bool = True,
    queued: bool = False,
) -> Iterator[RunRecords]:
    """Read the records of lines along while they are followed, into a file if one is named.

    See `recording.recorded`. The file is written whatever ends the lines, and what it does not hold
    is said.
    """
    with contextlib.ExitStack() as stack:
        rows = stack.enter_context(recording.writing(path)) if path else None
        found = RunRecords(path, rows)
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


_MOST_WAIT_S = 0.5
_FOLLOW_S = 0.2
_FOLLOW_HELP = "Go on until Ctrl-C."


class RecordRow(TypedDict):
    """A per-pixel record; `line` counts the axis' lines since reset, from 1."""

    line: int
    axis: int
    pixel: int
    expected_steps: int
    actual_steps: int
    edge_error_ticks: int


class AxisRecordCounts(TypedDict):
    """How many records of an axis were read, and were overwritten before that."""

    axis: int
    read: int
    missed: int


class LoggedRecords(TypedDict):
    """The records that were read from a board; `rows` only if a program named no file."""

    unit: int
    axes: list[AxisRecordCounts]
    rows: list[RecordRow]


class LoggedEvent(TypedDict):
    """A fault or a reset; the time is since the board's last reset."""

    number: int
    code: int
    axis: int
    argument: int
    pixel: int
    time_ms: int
    name: str
    text: str


class LoggedEvents(TypedDict):
    """The events that a board still has."""

    unit: int
    events: list[LoggedEvent]


@operation("board log records")
class LogRecords(ToBoard):
    """Write per-pixel records as CSV, each as it comes.

    Reads until no axis is armed or moves; with --follow until Ctrl-C, line after line. The board
    keeps only the newest records: how many were overwritten before they were read is said at the
    end, and is exit status 1.
    """

    result = LoggedRecords
    has_json = False  # what it prints is a CSV file

    axes: tuple[int, ...] = some_axes()
    output: Path | None = option(
        OUTPUT, "CSV file to write, whole at the end.", "-o", "--output",
        default_text="the terminal",
    )  # fmt: skip
    follow: bool = flag(_FOLLOW_HELP)

    def run(self, desk: Desk) -> Result:
        """Read the records until nothing moves."""
        kept: list[RecordRow] = []
        with bus.one_board(desk, self) as (found, known), self._rows_to(desk) as put:
            if not known.board.has("clock_statistics"):
                note = boards.missing_feature(known.board.unit, "clock_statistics")
                desk.say((f"edge_error_ticks is always 0: {note}",))
            put(recording.HEADER)
            followed = [AxisLog(known.board, axis) for axis in known.axes(self.axes)]
            wait_s = _wait_s(known)
            ended = FINE
            try:
                while True:
                    for item in followed:
                        for row in item.poll():
                            put(row.text)
                            if desk.keeps and self.output is None:
                                kept.append(_data(row))
                    moves = any(item.state in regs.MOVING_STATES for item in followed)
                    if not (self.follow or moves):
                        break
                    found.world.wait(wait_s)
            except signals.EndedBySignal as error:  # what was read is kept
                ended = signals.status(error)
            except KeyboardInterrupt:
                pass
        text = _records_text(followed)
        desk.aside(text)
        axes = [{"axis": one.axis, "read": one.rows, "missed": one.missed} for one in followed]
        missed = NEGATIVE if any(item.missed for item in followed) else FINE
        data = {"unit": self.unit, "axes": axes, "rows": kept}
        return Result(data, text, ended or missed, told=True)

    @contextlib.contextmanager
    def _rows_to(self, desk: Desk) -> Iterator[Callable[[str], None]]:
        """Yield what takes rows: the page, the standard output, or a file that appears whole."""
        if self.output is None:
            yield desk.tell
        elif atomic.is_stdout(self.output):
            yield functools.partial(print, flush=True)
        else:
            with (
                atomic.replacing(self.output) as temporary,
                temporary.open("w", encoding="ascii", newline="\n") as file,
            ):
                yield functools.partial(print, file=file)


@operation("board log events")
class LogEvents(ToBoard):
    """Print faults and resets with their times.

    Times are since the board's last reset. Refused for a board without an event log (`pixstep board
    features`).
    """

    result = LoggedEvents
    json_rows = "event"

    follow: bool = flag(_FOLLOW_HELP)

    def run(self, desk: Desk) -> Result:
        """Read the events; with `follow` again and again."""
        told = _Events(desk, keeps=desk.keeps or not self.follow)
        with bus.one_board(desk, self) as (found, known), signals.until_ctrl_c():
            known.board.require("events")
            total, events = known.board.events()
            if total > len(events):
                desk.say((f"{total - len(events)} older events are no longer kept",))
            told.take(events)
            while self.follow:
                found.world.wait(_FOLLOW_S)
                told.take(known.board.events()[1])
        return Result({"unit": self.unit, "events": told.rows}, "\n".join(told.texts), told=True)


class _Events:
    """Tells events, each once."""

    def __init__(self, desk: Desk, *, keeps: bool):
        self._desk, self._keeps = desk, keeps
        self._seen = 0
        self.rows: list[LoggedEvent] = []
        self.texts: list[str] = []

    def take(self, events: list[Event]) -> None:
        """Tell those that are new."""
        for event in events:
            if event.number <= self._seen:
                continue
            told = {**vars(event), "name": event.name, "text": event.text}
            row = cast("LoggedEvent", told)
            self._desk.row(row)
            self._desk.tell(_event_text(event))
            if self._keeps:
                self.rows.append(row)
                self.texts.append(_event_text(event))
        self._seen = max([self._seen, *(event.number for event in events)])


def _wait_s(known: Known) -> float:
    """Return how long to wait between looks so that no record is overwritten unread."""
    period_s = known.board.pixel_period_s()
    every = known.board.setting("record_every")
    return min(_MOST_WAIT_S, period_s * every * known.board.record_capacity() / 3)


def _data(row: RecordedPixel) -> RecordRow:
    return cast("RecordRow", {"line": row.line, "axis": row.axis, **vars(row.record)})


def _records_text(followed: list[AxisLog]) -> str:
    """Return in words how many records were read, and overwritten unread."""
    text = f"{sum(item.rows for item in followed)} records"
    each = ", ".join(f"{item.missed} of axis {item.axis}" for item in followed if item.missed)
    if not each:
        return f"{text}, none missed"
    return (
        f"{text}; missed: {each}, overwritten before they were read (`board upload`, `start` and "
        f"`run` read them while the line runs)"
    )


def _event_text(event: Event) -> str:
    """Return an event as a line."""
    time = f"{event.number:>5}  {event.time_ms / 1000:>10.3f} s  {event.name}"
    if event.name == "reset":
        return f"{time}: {event.text}"
    where = f"axis {event.axis}, pixel {event.pixel}, argument {event.argument}"
    return f"{time}: {event.text} ({where})"
