# SPDX-License-Identifier: MIT
"""The per-pixel records of lines, read along while they run: each once, and how many were missed.

A board keeps only the newest records of each axis, of every pixel or thinned by the setting
record_every. They are numbered by their pixel in the line, and which line it is follows from
lines_done: the records of a line that moves or was stopped by a fault belong to the one behind
those done. The board counts the records that a line has made, so what was overwritten unread is
known exactly.

Files of records, CSV or Parquet by their ending, are written while the records come. How many
records a host can read before they are overwritten depends on the pixel frequency, the axes and the
baud rate: where that is not all of them, the board is told to keep every Nth (setting
record_every), and every deviation besides.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from pixstep import atomic
from pixstep.board import registers as regs
from pixstep.board import settings, values
from pixstep.board.device import Device
from pixstep.board.errors import BoardError
from pixstep.board.link import World
from pixstep.board.run import LinesOfBoard
from pixstep.board.state import NewestRecords, Record
from pixstep.board.upload import LineUpload, feed
from pixstep.errors import UserError

HEADER = "line,axis,pixel,expected_steps,actual_steps,edge_error_ticks"
_TRIES = 4
_WORD = 0xFFFF
_UNFINISHED = ("running", "fault")


@dataclass(frozen=True)
class RecordedPixel:
    """One record; `line` counts the axis' lines since reset, from 1."""

    line: int
    axis: int
    record: Record

    @property
    def text(self) -> str:
        """The row of the CSV file."""
        found = self.record
        return (
            f"{self.line},{self.axis},{found.pixel},{found.expected_steps},"
            f"{found.actual_steps},{found.edge_error_ticks}"
        )


class AxisLog:
    """The records of one axis, read again and again.

    The newest record of a line that moves is held back until the next look: the error of its clock
    edge may not be known yet. `line` is the number of the line that is read from its beginning, 0
    if that is to be found out.
    """

    def __init__(self, board: Device, axis: int, line: int = 0) -> None:
        self._board, self.axis = board, axis
        self._line = line
        self._pixel = 0  # of the newest record that was given out
        self._made = 0  # records of the line that were given out or missed
        self._held: Record | None = None
        self.rows = 0
        self.missed = 0
        self.state = ""

    def poll(self) -> list[RecordedPixel]:
        """Return the records that have come since the last time.

        Raises BoardError as the board does.
        """
        line, block = self._read()
        return self.take(block, line, ended=self.state not in regs.MOVING_STATES)

    def take(
        self, block: NewestRecords, line: int | None = None, *, ended: bool
    ) -> list[RecordedPixel]:
        """Return the new records of a block; `ended` if the line makes no more.

        Without the number of the line it is the same one, or the next if pixels count anew.
        """
        records = block.records
        anew = bool(records) and records[-1].pixel < self._pixel
        if line is None:
            line = self._line + anew
        before = []
        if line != self._line or anew:
            before = self._rows([self._held] if self._held else [])
            self._line, self._pixel, self._made, self._held = line, 0, 0, None
        fresh = [record for record in records if record.pixel > self._pixel]
        if self._held and (not fresh or fresh[0].pixel > self._held.pixel):
            fresh.insert(0, self._held)  # overwritten since
        if not fresh:
            return before
        self.missed += (block.made - self._made - len(fresh)) & _WORD
        self._made, self._held = block.made, None
        if not ended:
            self._held = fresh.pop()
            self._made -= 1
        return before + self._rows(fresh)

    def _rows(self, records: list[Record]) -> list[RecordedPixel]:
        """Give records out."""
        self.rows += len(records)
        if records:
            self._pixel = records[-1].pixel
        return [RecordedPixel(self._line, self.axis, record) for record in records]

    def _read(self) -> tuple[int, NewestRecords]:
        """Return the line and its records, of one moment."""
        before = (self._number(), self.state)
        for _ in range(_TRIES):
            records = self._board.record_block(self.axis)
            # A line that ended meanwhile may have made its last records behind those just read.
            after = (self._number(), self.state)
            if after == before:
                break
            before = after
        return before[0], records

    def _number(self) -> int:
        """Return the number of the line that the records belong to."""
        found = self._board.axis(self.axis)
        self.state = regs.axis_state(found["axis_state"])
        if self.state in _UNFINISHED:
            return found["lines_done"] + 1
        # Until the next line begins, the records are those of the last.
        return max(self._line, found["lines_done"], 1)


if TYPE_CHECKING:
    import pyarrow

COLUMNS = (
    "unit", "line", "axis", "pixel", "expected_steps", "actual_steps", "edge_error_ticks",
)  # fmt: skip
CSV, PARQUET = ".csv", ".parquet"
_GROUP = 1 << 16  # rows of a Parquet file that are written at once


class RecordSink(Protocol):
    """What takes the records of boards."""

    def take(self, unit: int, row: RecordedPixel) -> None:
        """Take a record of a board."""

    def close(self) -> None:
        """Write what is left."""


def refuse_name(path: Path) -> None:
    """Raise UserError for a name that does not say its form; a stream gets CSV."""
    if path.suffix.lower() not in (CSV, PARQUET) and not atomic.is_stream(path):
        raise UserError(f"{path}: a file of records ends with {CSV} or {PARQUET}")


@contextlib.contextmanager
def writing(path: Path) -> Iterator[RecordSink]:
    """Yield what takes records; the file appears whole at the end.

    What was read before an error is in it as well; if that was nothing there is no file. A file
    that cannot be written further, as on a full disk, does not end the block. Raises UserError for
    that at the end, at once for another ending, and where Parquet is wanted without pyarrow.
    """
    refuse_name(path)
    failure: BaseException | None = None
    with atomic.replacing(path) as place:
        is_parquet = path.suffix.lower() == PARQUET
        rows = _Patient(_Parquet(path, place) if is_parquet else _Csv(place))
        try:
            yield rows
        except BaseException as error:
            failure = error
        rows.close()
        if failure is not None and not rows.any:
            raise failure  # and no file: the next try needs the name
    if failure is not None:
        raise failure


class _Patient:
    """Takes records on, whatever becomes of their file: motors move meanwhile."""

    def __init__(self, rows: RecordSink) -> None:
        self._rows = rows
        self._failure: OSError | None = None
        self.any = False

    def take(self, unit: int, row: RecordedPixel) -> None:
        """Take a record of a board."""
        self.any = True
        if self._failure is None:
            try:
                self._rows.take(unit, row)
            except OSError as error:
                self._failure = error

    def close(self) -> None:
        """Write what is left. Raises what the system had against the file."""
        if self._failure is not None:
            raise self._failure
        self._rows.close()


def _values(unit: int, row: RecordedPixel) -> tuple[int, ...]:
    found = row.record
    return (
        unit, row.line, row.axis, found.pixel, found.expected_steps, found.actual_steps,
        found.edge_error_ticks,
    )  # fmt: skip


class _Csv:
    """A row for each record, as the boards' log has them, behind the address of the board."""

    def __init__(self, place: Path) -> None:
        self._file = place.open("w", encoding="ascii", newline="\n")
        print(",".join(COLUMNS), file=self._file)

    def take(self, unit: int, row: RecordedPixel) -> None:
        """Take a record of a board."""
        print(",".join(map(str, _values(unit, row))), file=self._file)

    def close(self) -> None:
        """Write what is left."""
        self._file.close()


class _Parquet:
    """Whole columns, a group of rows at a time, so that no length needs memory."""

    def __init__(self, path: Path, place: Path) -> None:
        try:
            import pyarrow  # heavy, and wanted for Parquet only
            import pyarrow.parquet
        except ModuleNotFoundError:
            raise UserError(
                f"{path}: Parquet needs pyarrow: pip install 'pixstep[parquet]', or use .csv"
            ) from None
        self._arrow = pyarrow
        self._schema: pyarrow.Schema = pyarrow.schema([(name, pyarrow.int32()) for name in COLUMNS])
        self._writer = pyarrow.parquet.ParquetWriter(place, self._schema)
        self._rows: list[tuple[int, ...]] = []

    def take(self, unit: int, row: RecordedPixel) -> None:
        """Take a record of a board."""
        self._rows.append(_values(unit, row))
        if len(self._rows) >= _GROUP:
            self._flush()

    def close(self) -> None:
        """Write what is left."""
        self._flush()
        self._writer.close()

    def _flush(self) -> None:
        columns = list(zip(*self._rows, strict=True)) or [()] * len(COLUMNS)
        self._writer.write_table(
            self._arrow.table(dict(zip(COLUMNS, columns, strict=True)), schema=self._schema)
        )
        self._rows = []


EVERY = "record_every"
_MOST_EVERY = 10_000  # of the setting
_BITS = 11  # of a byte on the line: start, eight, parity, stop
_FRAME = 13  # bytes of a request and around the words of its reply
_LATENCY_S = 0.01  # from a request to the next, beside the bytes
_POLL_S = 0.08  # between two looks, of whoever follows a line, on a host that has more to do
_KEPT = 0.9  # the share of the time for which a board keeps a record, from look to look
_OFTEN = 0.4  # the same, as it is aimed at
_MOST_S = 0.5
_PIXEL_BYTES = 1.5  # of a line that goes over the bus at the same time, at most,
_MOST_SHARE = 0.75  # which takes so much of its time from the records, never more

Take = Callable[[RecordedPixel], None]


class Recorder:
    """What reads the records of one board's lines; `run.follow` asks it to look.

    `take` gets each record once, those of an axis in their order.
    """

    def __init__(self, board: Device, axes: list[int], take: Take, pixel_s: float) -> None:
        self._board, self._take = board, take
        found = board.axes(max(axes) + 1)
        self.logs = [AxisLog(board, axis, found[axis]["lines_done"] + 1) for axis in axes]
        self.every = board.setting(EVERY)
        self._pause_s = min(_MOST_S, _OFTEN * board.record_capacity() * self.every * pixel_s)
        self._due_s = 0.0

    @property
    def rows(self) -> dict[int, int]:
        """How many records there are, by axis."""
        return {log.axis: log.rows for log in self.logs}

    @property
    def missed(self) -> dict[int, int]:
        """How many were overwritten before they were read, by axis."""
        return {log.axis: log.missed for log in self.logs}

    def look_if_due(self, world: World, uploads: list[LineUpload]) -> None:
        """Read what is new, if it is time for that; what is left of lines is sent in between."""
        now_s = world.now_s()
        if now_s >= self._due_s:
            self._due_s = now_s + self._pause_s
            self.look(uploads)

    def look(self, uploads: list[LineUpload], *, ended: bool = False) -> None:
        """Read what is new; `ended` if no line makes any more."""
        for log in self.logs:
            block = self._board.short_record_block(log.axis)
            for row in log.take(block, ended=ended) if block else ():  # else at the next look
                self._take(row)
            if not ended:
                feed(uploads)


def every_of(hz: Fraction, axes: int, capacity: int, baud: int, *, streamed: bool) -> int:
    """Return every how many pixels a record can be read before a board overwrites it.

    `hz` is the frequency of pixels, `axes` the number of axes, `capacity` how many records a board
    keeps of each; `streamed` if their lines are sent meanwhile.
    """
    record_words = regs.RECORD_HEAD + capacity * regs.RECORD_REGISTERS
    frames = [_FRAME + 2 * record_words] * axes + [_FRAME + 2 * regs.AXIS_STRIDE * axes, 2 * _FRAME]
    if streamed:
        frames += [2 * _FRAME] * axes  # after each axis the queues are asked for room
    look_s = sum(frames) * _BITS / baud + len(frames) * _LATENCY_S
    share = float(hz) * axes * _PIXEL_BYTES * _BITS / baud if streamed else 0.0
    unread_s = _POLL_S + look_s / (1 - min(share, _MOST_SHARE))
    return min(_MOST_EVERY, max(1, math.ceil(float(hz) * unread_s / (_KEPT * capacity))))


@contextlib.contextmanager
def recorded(
    lines: LinesOfBoard,
    take: Take,
    *,
    streamed: bool = True,
    queued: bool = False,
    axes_together: int | None = None,
) -> Iterator[Recorder | None]:
    """Let `run.follow` read the records of lines; yield what does, None of a board without any.

    Enter it when the board's clock is set and before the lines are queued; once they are `queued`
    the board keeps as many records as it was set to. `streamed` says that lines may be longer than
    a queue, `axes_together` how many axes of all boards on the bus are read meanwhile. The board is
    set back after the lines, if no fault forbids that; not where they are locked to the clock or
    the clock is gated, because a board measures its clock anew after every change of a setting.
    """
    board = lines.board
    capacity = board.record_capacity()
    if not capacity:
        yield None
        return
    known = settings.read(board)
    hz = values.hz_of(known) / settings.divider_of(known)
    before = wanted = known[EVERY]
    if not queued:
        baud = 100 * known["baud_100"]
        axes = axes_together or len(lines.axes)
        wanted = max(before, every_of(hz, axes, capacity, baud, streamed=streamed))
    if wanted != before:
        board.write_setting(EVERY, wanted)
    lines.recorder = Recorder(board, lines.axes, take, float(1 / hz))
    try:
        yield lines.recorder
    finally:
        lines.recorder = None
        if wanted != before and not (settings.locks(known) or settings.gate_of(known)):
            with contextlib.suppress(BoardError), board.once():
                board.write_setting(EVERY, before)
