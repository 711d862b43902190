# SPDX-License-Identifier: MIT
"""A program planned to counts per pixel, as a stream: memory does not grow with its length.

A plan is made by this process, or by one of its own: planning the first window of a program takes
longer than a board's queue lasts. In a process of its own it keeps no board waiting; the pipe
between both holds it back when it is far ahead. A plan that becomes files is no longer than what
reads a line file takes.
"""

import contextlib
import os
import pickle
import subprocess
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from typing import Any, BinaryIO, Self, TextIO

import numpy as np

from pixstep.errors import AskedText, PlainError, RefusedError, UserError
from pixstep.formats.records import CRLF, CSV_COLUMNS, MAX_BYTES
from pixstep.programs import jerk, language
from pixstep.programs.blends import NominalPath, Timed, nominal
from pixstep.programs.language import ProgramError
from pixstep.programs.motors import Setup
from pixstep.programs.moves import Dwell, Program, ProgramMove
from pixstep.programs.pixels import (
    Counts,
    ProgramTrack,
    Rounding,
    Timeline,
    as_programmed,
    in_pieces,
    timelines,
)
from pixstep.programs.plan_data import MODE1, MODES, PlanOptions
from pixstep.programs.report import Report
from pixstep.programs.time_law import TimeLaw, refined
from pixstep.programs.two_moves import TwoMoves

_TOGETHER = 16_384  # pixels that are made at once, however long a move is
_MOST_CORNERS = 20_000  # that a drawing shows
_MODE1_WINDOW = 256  # moves that the time law sees of what mode1 has timed


def with_segments(setup: Setup, mode: str, segment_ms: float | None) -> Setup:
    """Return the setup for a mode: with these segments, with none for mode1 if it is not told.

    Raises UserError for segments in mode1.
    """
    if mode == MODE1 and segment_ms:
        raise UserError(
            AskedText("mode1 has no segments: leave {segment} out, or plan with {mode} lookahead")
        )
    if segment_ms is None:
        return replace(setup, segment_ms=0.0) if mode == MODE1 else setup
    return replace(setup, segment_ms=float(segment_ms))


class Plan:
    """A program that is planned as its counts are asked for; `report` is complete at the end."""

    def __init__(
        self, name: str, text: Iterable[str], setup: Setup, options: PlanOptions | None = None
    ) -> None:
        self.name, self.setup = name, setup
        self.options = options or PlanOptions()
        if self.options.mode not in MODES:
            raise UserError(f"mode {self.options.mode!r}: expected one of {', '.join(MODES)}")
        self._keeps_jerk = self.options.mode != MODE1 and jerk.limits_jerk(setup)
        self.report = Report.of(setup, keeps_jerk=self._keeps_jerk)
        self._text = text
        self.corners: list[tuple[float, ...]] = []  # where the first moves end, in counts

    def counts(self) -> Iterator[Counts]:
        """Yield counts of pixels, a column for each motor, a row for each pixel."""
        pieces = in_pieces(self.timelines(), _TOGETHER * self.setup.pixel_ms)
        rounding = Rounding(self.setup)
        for part in rounding.counts(ProgramTrack(pieces, self.setup)):
            self.report.add_counts(part)
            yield part
        self.report.off_path = rounding.off
        if not self.report.moves:
            raise ProgramError(f"{self.name}:1:1: nothing moves in this program")

    def timelines(self) -> Iterator[Timeline]:
        """Yield the plan in time, before it is rounded."""
        program = Program(self.name, self.setup, circles=self.options.mode != MODE1)
        events = program.events(language.read(self.name, self._text))
        limits = self.report.limits
        if self.options.mode == MODE1:
            two = TwoMoves(self.setup, assume_last=self.options.assume_last)
            path = NominalPath(len(self.setup.motors)).intervals(self._noted(two.timed(events)))
            kept = TimeLaw(limits, _MODE1_WINDOW).runs(path)
            runs = kept if two.assume_last else as_programmed(path)
            self.report.violations = two.violations
        else:
            two = None
            path = NominalPath(len(self.setup.motors)).intervals(self._noted(nominal(events)))
            first = TimeLaw(limits, self.options.window).runs(path)
            second = TimeLaw(limits, self.options.window).runs(refined(first, limits))
            runs = TimeLaw(limits, self.options.window).runs(refined(second, limits))
        if self._keeps_jerk:
            lines = jerk.smoothed(self.name, runs, limits, self.setup)
        else:
            lines = timelines(runs, limits, programmed=two is not None and not two.assume_last)
        for line in lines:
            self.report.add_time(line)
            if self._keeps_jerk:
                self.report.add_jerks(jerk.jerks(line, self.setup))
            yield line
        self.report.note_move()
        self.report.arc_off_steps = program.arc_off_steps
        if two:
            self.report.violated = two.violated

    def _noted(self, moves: Iterable[Timed | Dwell]) -> Iterator[Timed | Dwell]:
        """Yield the moves, noted for the report; what a smooth motor cannot do is refused."""
        smooth = _SmoothRules(self.name, self.setup)
        last: Timed | None = None
        for item in moves:
            if isinstance(item, Timed):
                smooth.move(item)
                self.report.add_move(item)
                if len(self.corners) < _MOST_CORNERS:
                    self.corners.append(item.target)
                last = item
            else:
                if last:
                    smooth.stop(last)
                self.report.add_stop(item.ms)
            yield item
        if last:
            smooth.stop(last)
        self.report.add_stop()


class _SmoothRules:
    """A smooth line has one direction, and comes to rest on even steps."""

    def __init__(self, name: str, setup: Setup) -> None:
        self.name = name
        self.motors = [(index, motor) for index, motor in enumerate(setup.motors) if motor.smooth]
        self._places = [0.0] * len(setup.motors)
        self._ways = [0] * len(setup.motors)

    def move(self, move: Timed) -> None:
        """Look at a move. Raises ProgramError if a motor would turn round."""
        for index, motor in self.motors:
            length = move.target[index] - self._places[index]
            self._places[index] = move.target[index]
            way = (length > 0) - (length < 0)
            if way and way == -self._ways[index]:
                raise ProgramError(
                    f"{self.name}:{move.line}:1: motor {motor.name} is smooth and would turn "
                    f"round: a smooth line has one direction (kind plain turns)"
                )
            self._ways[index] = self._ways[index] or way

    def stop(self, move: Timed) -> None:
        """Look at where a move stops. Raises ProgramError for odd steps."""
        for index, motor in self.motors:
            whole = round(move.target[index])
            if whole % 2:
                raise ProgramError(
                    f"{self.name}:{move.line}:1: motor {motor.name} is smooth and would stop at "
                    f"step {whole}: the speeds of a smooth line are even, and so is its sum: "
                    f"nearest {whole - 1} and {whole + 1}"
                )


_END = Dwell(0, 0.0)
MOST_PIXELS = MAX_BYTES // (CSV_COLUMNS.width + len(CRLF))
_ADVICE = (
    f"a line file holds {MOST_PIXELS}: run the program as it is, which takes any length (`pixstep "
    f"board run`, from Python run_program), or divide it"
)


def require_length(name: str, text: Iterable[str], setup: Setup, options: PlanOptions) -> None:
    """Read a program, which is quick; no plan is shorter than what it says.

    Raises ProgramError for the move or the dwell with which it is too long, and for mistakes.
    """
    total_ms = 0.0
    program = Program(name, setup, circles=options.mode != MODE1)
    for event, ms in _least_times(program.events(language.read(name, text)), setup):
        total_ms += ms
        pixels = total_ms / setup.pixel_ms
        if pixels > MOST_PIXELS:
            raise ProgramError(
                f"{name}:{event.line}:1: up to here the program takes {total_ms / 1000:.6g} s = "
                f"{pixels:.0f} pixels at {float(setup.pixel_hz):g} Hz, and {_ADVICE}"
            )


def _least_times(
    events: Iterable[ProgramMove | Dwell], setup: Setup
) -> Iterator[tuple[ProgramMove | Dwell, float]]:
    """Yield what a program does with a time, ms, that each takes at least.

    A move is no faster than its motors in what is left of it between two blends.
    """
    places = np.zeros(len(setup.motors))
    fastest = np.array([motor.planned_speed(setup.pixel_ms) for motor in setup.motors])
    for event, following in pairwise(chain(events, (_END,))):
        if not isinstance(event, ProgramMove):
            yield event, event.ms
            continue
        target = np.array(event.target)
        least = float(np.max(np.abs(target - places) / fastest))
        places = target
        blend = following.ta if isinstance(following, ProgramMove) else event.ta
        between = max(1 - (event.ta + blend) / 2 / event.tm, 0.0)
        yield event, event.tm + max(least - event.tm, 0.0) * between


def bounded(plan: Plan) -> Iterator[Counts]:
    """Yield the counts of a plan; limits may make it longer than the program says.

    Raises RefusedError where it is too long.
    """
    for part in plan.counts():
        if plan.report.pixels > MOST_PIXELS:
            raise RefusedError(
                f"{plan.name}: by its limits the plan takes more than {MOST_PIXELS} pixels at "
                f"{float(plan.setup.pixel_hz):g} Hz, and {_ADVICE}"
            )
        yield part


_PLAN_FOR_ANOTHER = "from pixstep.programs.plan import plan_for_another as go; go()"
_IN_MESSAGE = 2048  # pixels in a message
_MESSAGES = 16  # that wait to be taken
COUNTS, ERROR, ENDED = "counts", "error", "end"


@dataclass(frozen=True)
class PlanRequest:
    """A program file and how it is to be planned."""

    path: str
    setup: Setup
    options: PlanOptions

    def text(self) -> TextIO:
        """Open the program; wrong bytes become characters that no statement has.

        Raises UserError if that fails.
        """
        try:
            return Path(self.path).open(encoding="utf-8", errors="replace")
        except OSError as error:
            raise UserError(f"{self.path}: {error.strerror}") from None

    def parts(self) -> Iterator[Counts]:
        """Yield the counts of the plan, not many at a time."""
        with self.text() as text:
            for part in Plan(self.path, text, self.setup, self.options).counts():
                for first in range(0, len(part), _IN_MESSAGE):
                    yield part[first : first + _IN_MESSAGE]


class PlanProcess:
    """A plan that another process makes: `with PlanProcess(request) as source:`."""

    def __init__(self, request: PlanRequest) -> None:
        self.over = False  # True when all counts have been taken
        self._request = request
        self._messages: Queue[tuple[str, Any]] = Queue(_MESSAGES)
        self._closed = False

    def __enter__(self) -> Self:
        # In a session of its own Ctrl-C does not reach it: this process ends it.
        self._process = subprocess.Popen(
            [sys.executable, "-c", _PLAN_FOR_ANOTHER],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
        try:
            pipe = self._process.stdin
            assert pipe is not None
            pickle.dump(self._request, pipe)  # it stays open: its end is the process's, too
            pipe.flush()
            self._reader = Thread(target=self._read, daemon=True)
            self._reader.start()
        except BaseException:
            self._process.kill()
            self._process.wait()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self._closed = True
        self._process.kill()
        while self._reader.is_alive():
            self.more(wait=False)  # makes room for what the reader holds
            self._reader.join(0.01)
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            pipe.close()

    def more(self, *, wait: bool) -> Counts | None:
        """Return counts of some more pixels, a row each; None at the end.

        Without `wait` also None if none are planned yet. Raises UserError for a mistake in the
        program.
        """
        if self.over:
            return None
        try:
            kind, found = self._messages.get(block=wait)
        except Empty:
            return None
        if kind == COUNTS:
            return np.asarray(found, dtype=np.int64)
        self.over = True
        if kind == ERROR and not self._closed:
            raise found
        return None

    def _read(self) -> None:
        """Take the messages of the process; a process that ends without a word is an error."""
        assert self._process.stdout is not None
        kind = COUNTS
        while kind == COUNTS:
            try:
                kind, found = pickle.load(self._process.stdout)
            except (EOFError, OSError, pickle.UnpicklingError):
                kind, found = ERROR, PlainError(f"{self._request.path}: the planner has ended")
            self._messages.put((kind, found))


def plan_for_another() -> None:
    """Plan what the standard input asks for; end quietly when nobody takes it any more."""
    request: PlanRequest = pickle.load(sys.stdin.buffer)
    Thread(target=_end_with_the_other, daemon=True).start()
    out = sys.stdout.buffer
    with contextlib.suppress(BrokenPipeError):
        try:
            for part in request.parts():
                _send(out, COUNTS, part.astype(np.int32))
            _send(out, ENDED, None)
        except PlainError as error:
            _send(out, ERROR, error)


def _end_with_the_other() -> None:
    """End this process when the one that asks has ended, however that was: its pipe closes then.

    The bare descriptor is read: a reader that waits in sys.stdin keeps the interpreter from ending.
    """
    with contextlib.suppress(OSError):
        while os.read(sys.stdin.fileno(), 1):
            pass
    os._exit(1)


def _send(out: BinaryIO, kind: str, found: object) -> None:
    pickle.dump((kind, found), out, pickle.HIGHEST_PROTOCOL)
    out.flush()
