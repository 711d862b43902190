# SPDX-License-Identifier: MIT
"""The logs of a board: per-pixel records as they come, and the events."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypedDict

from pixstep import atomic, signals
from pixstep.board import boards, recording
from pixstep.board.recording import AxisLog, Row
from pixstep.board.state import Event
from pixstep.errors import FINE, NEGATIVE
from pixstep.operations import bus
from pixstep.operations.bus import Known, ToBoard, some_axes
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import OUTPUT
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result

_MOST_WAIT_S = 0.5
_MOVES = ("armed", "running")
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


class AxisRecords(TypedDict):
    """How many records of an axis were read, and were overwritten before that."""

    axis: int
    read: int
    missed: int


class LoggedRecords(TypedDict):
    """What was read of a board's records; `rows` are there only for a program without a file."""

    unit: int
    axes: list[AxisRecords]
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
    """The events of a board that it still has."""

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
                    if not self.follow and all(item.state not in _MOVES for item in followed):
                        break
                    found.world.wait(wait_s)
            except signals.Ended as error:  # what was read is kept
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
            row: LoggedEvent = {
                "number": event.number, "code": event.code, "axis": event.axis,
                "argument": event.argument, "pixel": event.pixel, "time_ms": event.time_ms,
                "name": event.name, "text": event.text,
            }  # fmt: skip
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


def _data(row: Row) -> RecordRow:
    found = row.record
    return {
        "line": row.line,
        "axis": row.axis,
        "pixel": found.pixel,
        "expected_steps": found.expected_steps,
        "actual_steps": found.actual_steps,
        "edge_error_ticks": found.edge_error_ticks,
    }


def _records_text(followed: list[AxisLog]) -> str:
    """Return in words how many records were read, and overwritten unread."""
    text = f"{sum(item.rows for item in followed)} records"
    each = ", ".join(f"{item.missed} of axis {item.axis}" for item in followed if item.missed)
    if not each:
        return f"{text}, none missed"
    return (
        f"{text}; missed: {each}, overwritten before they were read (`board upload`, `start` and "
        f"`run` have --records, which reads them while the line runs)"
    )


def _event_text(event: Event) -> str:
    """Return an event as a line."""
    time = f"{event.number:>5}  {event.time_ms / 1000:>10.3f} s  {event.name}"
    if event.name == "reset":
        return f"{time}: {event.text}"
    where = f"axis {event.axis}, pixel {event.pixel}, argument {event.argument}"
    return f"{time}: {event.text} ({where})"
