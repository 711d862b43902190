# SPDX-License-Identifier: MIT
"""Lines of a job on the boards: armed once, chained by the boards, one line queued ahead.

    queued 1, queued 2 -> blocks -> arm -> line 1 moves
    line 1 confirmed -> done 1 -> queued 3 -> blocks -> line 2 moves ...

A line is done when every board says so by its counters and by its position. So at most two lines
are between `queued` and `done`: the one that moves, and the next one.
"""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum

from pixstep import signals
from pixstep.board import recording, run, snapshot, together
from pixstep.board.errors import BoardError
from pixstep.board.link import World
from pixstep.board.recording import RecordedPixel
from pixstep.board.together import Together
from pixstep.jobs import account, run_log, stations
from pixstep.jobs.account import JobAxis
from pixstep.jobs.gaps import Gaps
from pixstep.jobs.job import Job
from pixstep.jobs.run_folder import Parts
from pixstep.jobs.run_log import Event
from pixstep.jobs.sender import Sender
from pixstep.jobs.stations import Station
from pixstep.machine.files import MachineFile
from pixstep.progress import Progress, unseen

_STATUS_S, _LOOK_S, _LEAST_S = 0.05, 0.25, 0.02
_LOOKS_A_LINE = 8
_TIMEOUT_S, _RETRIES = 0.2, 3  # so that a board that is lost is named within a second
_AHEAD = 2  # lines that may be queued and not done


class ChainEnd(Enum):
    """How a chain of lines has ended without a fault."""

    FINISHED = "finished"
    PAUSED = "paused"
    DRY = "dry"  # the host was late: all axes rest at the end of the same line


class JobBrokenError(BoardError):
    """A run has ended before its end; `rows` say where each motor is."""

    def __init__(self, message: str, rows: Iterable[Event] = ()) -> None:
        super().__init__(message)
        self.rows = [*rows]


@dataclass
class RunWatch:
    """What whoever started a run is told, and what it may ask for.

    Lines can pause, `in_lines`; what goes before them can only be stopped.
    """

    pause_asked: Callable[[], bool] = lambda: False
    progress: Progress = unseen
    say: Callable[[str], None] = lambda text: None
    in_lines: bool = False


@dataclass
class Chain:
    """Lines `first` to `last` of a job, one after the other without a gap.

    `made` is the last line that every board has confirmed, `reserve_px` how many pixels before its
    turn a line was in the queues as a whole, at the least. Boards that begin together are armed
    with `token`, or one made at random.
    """

    job: Job
    machine: MachineFile
    stations: list[Station]
    world: World
    note: Callable[[Event], None]
    watch: RunWatch
    first: int
    last: int
    parts: Parts | None = None
    gaps: Gaps | None = None
    token: int | None = None
    made: int = field(init=False)
    reserve_px: float = field(default=math.inf, init=False)
    lost: dict[str, BoardError] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.made = self.first - 1
        clock = self.machine.clock
        self._pixel_s = float(1 / self.machine.pixel_hz)
        self._looked_s = 0.0
        self._blocks: dict[str, int] = {}  # by motor: blocks taken at the last look
        self._paused, self._wanted = False, self.last  # a pause or a lost board lowers `last`
        self._sender = Sender(
            self.job, (self.first, self.last), clock.edges, self._intend,
            gated=bool(clock.gate_edges),
        )  # fmt: skip

    def make(self) -> ChainEnd:
        """Make the lines. Raises JobBrokenError saying where everything is."""
        group = [one.lines for one in self.stations]
        try:
            with self._recorded():
                self._begin()
                with run.stopped_on_failure(group):
                    started = self._start()
                    self.watch.in_lines = True
                    self._follow()
                self._read_last_records()
        except BoardError as error:
            raise self._broken(str(error)) from None
        except KeyboardInterrupt as error:
            self._broken(f"stopped by {signals.name(error)}")
            raise
        except BaseException as error:
            self._broken(f"stopped: {error!r}")
            raise
        finally:
            self.watch.in_lines = False
        if self.lost:
            raise self._broken("; ".join(map(str, self.lost.values())))
        if started:
            started.compare(self.world)
        return self._how()

    @property
    def late(self) -> list[str]:
        """The motors whose next line was not in their queue at the end of one, as boards say it."""
        return [axis.motor for one in self.alive for axis in one.axes() if axis.lacked_a_line]

    @property
    def alive(self) -> list[Station]:
        """The boards that answer and are without a fault."""
        return [one for one in self.stations if one.name not in self.lost]

    @contextlib.contextmanager
    def _recorded(self) -> Iterator[None]:
        """Let the boards' records be read along, if they are wanted."""
        with contextlib.ExitStack() as stack:
            axes = sum(len(one.motors) for one in self.stations)
            for station in self.stations if self.parts else ():
                stack.enter_context(
                    recording.recorded(station.lines, self._take(station), axes_together=axes)
                )
            yield
        if self.parts:
            self.parts.write(self.job.lines)

    def _take(self, station: Station) -> Callable[[RecordedPixel], None]:
        motors = {axis: name for name, axis in station.motors.items()}

        def take(row: RecordedPixel) -> None:
            if self.parts:
                name = motors[row.axis]
                line = self.first + (row.line - station.bases[name].lines_done - 1) % account.WRAPS
                self.parts.take(line, name, row.record)

        return take

    def _read_records(self, station: Station) -> None:
        """Read the records of a board that have come since, if it is their turn."""
        if station.lines.recorder:
            station.lines.recorder.look_if_due(self.world, [])

    def _read_last_records(self) -> None:
        for station in self.alive:
            if station.lines.recorder:
                station.lines.recorder.look([], ended=True)

    def _begin(self) -> None:
        for station in self.stations:
            snapshot.await_lock(station.board, self.world)
            station.rebase()
        bases = stations.bases_of(self.stations)
        self.note({"event": run_log.CHAIN, "line": self.first, "axes": bases})

    def _intend(self, line: int) -> None:
        self.note({"event": run_log.QUEUED, "line": line})

    def _start(self) -> Together | None:
        """Queue the first lines and start them, on one edge of the clock."""
        self._sender.send(self.stations, self._allowed())
        if len(self.stations) > 1:
            return together.start(
                [one.lines for one in self.stations], self.world, token=self.token
            )
        (station,) = self.stations
        run.arm_lines(station.lines)
        return None

    def _allowed(self) -> int:
        return min(self.last, self.made + _AHEAD)

    def _follow(self) -> None:
        """Send, look and log until all axes rest."""
        line_s = self.job.pixels * self._pixel_s
        look_s = max(_LEAST_S, min(_LOOK_S, line_s / _LOOKS_A_LINE))
        modbus = self.stations[0].board.modbus
        with modbus.patient(_TIMEOUT_S, _RETRIES):
            while True:
                begun_s = self._looked_s = self.world.now_s()
                self._each(self._judge)
                self._confirm()
                if self.watch.pause_asked() and not self._paused:
                    self._pause()
                if self._all_rest():
                    return
                self._send_until(begun_s + look_s)

    def _each(self, act: Callable[[Station], None]) -> None:
        """Act on every board; one that fails is lost, and the others end the lines they have."""
        for station in self.alive:
            try:
                act(station)
            except _BesideError:
                raise
            except BoardError as error:
                self._lose(station, error)

    def _lose(self, station: Station, error: BoardError) -> None:
        self.lost[station.name] = error
        self.last = min(self.last, self._sender.begun)
        self.note({
            "event": run_log.LOST, "board": station.name, "why": str(error), "last": self.last,
        })  # fmt: skip
        if not self.alive:
            raise error
        self.watch.say(
            f"{error}; the other boards stop at the end of line {self.last} at the latest"
        )

    def _judge(self, station: Station) -> None:
        """Look at a board's axes. Raises BoardError for what keeps a board from going on."""
        times = self.gaps if station is self.stations[0] else None
        for axis in times.look(station, self.first) if times else station.look():
            if axis.state == "fault":
                run.raise_fault(station.board)
            if axis.has_gone_back or self._has_fewer_blocks(axis):
                raise station.board.reset_error(axis.base.axis)
            if axis.state in ("empty", "refused"):
                run.raise_fault(station.board)
                station.board.require_no_reset(axis.base.axis)
                raise BoardError(
                    f"board {station.board.unit}: motor {axis.motor} is {axis.state}: stopped "
                    f"before its end"
                )

    def _has_fewer_blocks(self, axis: JobAxis) -> bool:
        """Return whether an axis has taken fewer blocks than it had at the last look."""
        before = self._blocks.get(axis.motor, 0)
        self._blocks[axis.motor] = axis.blocks
        return axis.blocks < before

    def _confirm(self) -> None:
        """Log the lines that every board has made."""
        if self.lost:
            self._require_one_line(self.alive)
            return
        made = min(self._require_one_line(self.stations), self.last)
        for line in range(self.made + 1, made + 1):
            self.made = line
            self.note({"event": run_log.DONE, "line": line})
            if self.parts:
                self.parts.write(line - 1)
        self._show()

    def _require_one_line(self, stations: list[Station]) -> int:
        """Return the last line that all axes have made.

        Raises an error if one has ended while another one is in a later line.
        """
        found = [(axis, self._line_of(axis)) for one in stations for axis in one.axes()]
        line = min(number for _, number in found)
        rests = [(axis, number) for axis, number in found if not axis.moves]
        late, next_line = min(rests, key=lambda one: one[1], default=(None, line))
        beyond = [
            axis for axis, number in found
            if number > next_line or (axis.moves and number == next_line)
        ]  # fmt: skip
        if late and beyond and next_line <= self.last:
            late = next((axis for axis, _ in rests if axis.lacked_a_line), late)
            raise _BesideError(
                f"motor {late.motor} ended after line {next_line - 1}, because line {next_line} "
                f"reached its queue too late, and motor {beyond[0].motor} made more alone: line "
                f"{next_line} is spoilt"
            )
        return line - 1

    def _line_of(self, axis: JobAxis) -> int:
        found = account.place_of(self.job, self.first, axis)
        if not found:
            raise _BesideError(
                f"motor {axis.motor} is at {axis.position_steps} steps, {axis.counted} lines after "
                f"line {self.first - 1}, pixel {axis.now['pixel']}: no line takes it there"
            )
        return found.line

    def _all_rest(self) -> bool:
        return not any(axis.moves for one in self.alive for axis in one.axes())

    def _pause(self) -> None:
        self._paused = True
        self.last = min(self.last, max(self._sender.begun, self.first))
        left_s = (self.last - self.made) * self.job.pixels * self._pixel_s
        self.watch.say(f"pauses at the end of line {self.last}, within {left_s:.1f} s")

    def _show(self) -> None:
        axes = [axis for one in self.stations for axis in one.axes()]
        pixel = min(axis.now["pixel"] if axis.moves else 0 for axis in axes)
        pixels = self.job.pixels
        passed = (self.made * pixels + min(pixel, pixels)) / (self.job.lines * pixels)
        self.watch.progress(passed)

    def _send_until(self, until_s: float) -> None:
        while True:
            begun_s, sent = self.world.now_s(), self._sender.sent
            try:
                self._sender.send(self.alive, self._allowed())
                if self._sender.sent > sent:
                    self._note_reserve(self._sender.sent)
            except BoardError:
                if not self._lose_silent():
                    raise
            self._each(self._read_records)
            rest_s = self._sender.pause_s(self.alive, self._pixel_s, _STATUS_S)
            self.world.wait(max(0.0, min(begun_s + rest_s, until_s) - self.world.now_s()))
            if self.world.now_s() >= until_s or not self._moving():
                return

    def _note_reserve(self, line: int) -> None:
        """Note how far the motors are from a line that is in the queues now."""
        passed = (self.world.now_s() - self._looked_s) / self._pixel_s
        pixel = max(axis.now["pixel"] for one in self.alive for axis in one.axes()) + passed
        before = (line - 1 - self.made) * self.job.pixels
        self.reserve_px = min(self.reserve_px, before - pixel)

    def _moving(self) -> bool:
        found = True

        def ask(station: Station) -> None:
            nonlocal found
            found = station.board.moving() and found

        self._each(ask)
        return found

    def _lose_silent(self) -> bool:
        """Lose the boards that do not go on; False if all of them do."""
        before = len(self.lost)
        self._each(self._judge)
        return len(self.lost) > before

    def _how(self) -> ChainEnd:
        if self.made < self.last:
            return ChainEnd.DRY
        return ChainEnd.PAUSED if self._paused and self.made < self._wanted else ChainEnd.FINISHED

    def _broken(self, why: str) -> JobBrokenError:
        """Log where everything is, as far as boards say it; return what to raise."""
        rows = [row for one in self.stations for row in self._rows(one)]
        self.note({"event": run_log.STOPPED, "line": self.made + 1, "why": why, "motors": rows})
        return JobBrokenError("; ".join([why, *map(_where, rows)]), rows)

    def _rows(self, station: Station) -> list[Event]:
        try:
            if station.name not in self.lost:
                station.look()
            axes = station.axes()
        except (BoardError, KeyError):
            return [{"motor": name, "board": station.name} for name in station.motors]
        rows = []
        for axis in axes:
            found = account.place_of(self.job, self.first, axis)
            row = {
                "motor": axis.motor, "board": station.name, "state": axis.state,
                "position_steps": axis.position_steps,
            }  # fmt: skip
            if station.name in self.lost:
                row["last_seen"] = True
            elif found:
                row |= {"line": found.line, "pixel": found.pixel}
            rows.append(row)
        return rows


def _where(row: Event) -> str:
    """Return where a motor is, in words."""
    if "position_steps" not in row:
        return f"where motor {row['motor']} is, is not known"
    seen = "last seen " if "last_seen" in row else ""
    text = f"motor {row['motor']} {seen}{row['state']} at {row['position_steps']}"
    return f"{text}, line {row['line']} pixel {row['pixel']}" if "line" in row else text


class _BesideError(BoardError):
    """Axes are no longer in the same line, or in none: everything is stopped at once."""
