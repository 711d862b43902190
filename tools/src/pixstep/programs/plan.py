# SPDX-License-Identifier: MIT
"""A program planned to counts per pixel, as a stream: memory does not grow with its length."""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import replace

from pixstep.errors import UserError
from pixstep.programs import jerk, language
from pixstep.programs.blends import Path, Timed, nominal
from pixstep.programs.language import ProgramError
from pixstep.programs.motors import Setup
from pixstep.programs.moves import Dwell, Move, Program
from pixstep.programs.options import MODE1, MODES, Options
from pixstep.programs.pixels import Counts, Rounding, Track
from pixstep.programs.report import Report
from pixstep.programs.timelaw import TimeLaw, refined
from pixstep.programs.timeline import Timeline, as_programmed, in_pieces, timelines
from pixstep.programs.twomoves import TwoMoves

_TOGETHER = 16_384  # pixels that are made at once, however long a move is
_MOST_CORNERS = 20_000  # that a drawing shows
_MODE1_WINDOW = 256  # moves that the time law sees of what mode1 has timed


def with_segments(setup: Setup, mode: str, segment_ms: float | None) -> Setup:
    """Return the setup for a mode: with these segments, with none for mode1 if it is not told.

    Raises UserError for segments in mode1.
    """
    if mode == MODE1 and segment_ms:
        raise UserError("mode1 has no segments: leave --segment out, or plan with --mode lookahead")
    if segment_ms is None:
        return replace(setup, segment_ms=0.0) if mode == MODE1 else setup
    return replace(setup, segment_ms=float(segment_ms))


class Plan:
    """A program that is planned as its counts are asked for; `report` is complete at the end."""

    def __init__(
        self, name: str, text: Iterable[str], setup: Setup, options: Options | None = None
    ) -> None:
        self.name, self.setup = name, setup
        self.options = options or Options()
        if self.options.mode not in MODES:
            raise UserError(f"mode {self.options.mode!r}: expected one of {', '.join(MODES)}")
        self._keeps_jerk = self.options.mode != MODE1 and jerk.limits_jerk(setup)
        self.report = Report.of(setup, keeps_jerk=self._keeps_jerk)
        self._text = text
        self._segments: deque[int] = deque()  # numbers in their circles of moves not timed yet
        self.corners: list[tuple[float, ...]] = []  # where the first moves end, in counts

    def counts(self) -> Iterator[Counts]:
        """Yield counts of pixels, a column for each motor, a row for each pixel."""
        pieces = in_pieces(self.timelines(), _TOGETHER * self.setup.pixel_ms)
        rounding = Rounding(self.setup)
        for part in rounding.counts(Track(pieces, self.setup)):
            self.report.add_counts(part)
            yield part
        self.report.off_path = rounding.off
        if not self.report.moves:
            raise ProgramError(f"{self.name}:1:1: nothing moves in this program")

    def timelines(self) -> Iterator[Timeline]:
        """Yield the plan in time, before it is rounded."""
        program = Program(self.name, self.setup, circles=self.options.mode != MODE1)
        events = self._told(program.events(language.read(self.name, self._text)))
        limits = self.report.limits
        if self.options.mode == MODE1:
            two = TwoMoves(self.setup, assume_last=self.options.assume_last)
            path = Path(len(self.setup.motors)).intervals(self._noted(two.timed(events)))
            kept = TimeLaw(limits, _MODE1_WINDOW).runs(path)
            runs = kept if two.assume_last else as_programmed(path)
            self.report.violations = two.violations
        else:
            two = None
            path = Path(len(self.setup.motors)).intervals(self._noted(nominal(events)))
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
        self.report.end()
        self.report.arc_off_steps = program.arc_off_steps
        if two:
            self.report.violated = two.violated

    def _told(self, events: Iterable[Move | Dwell]) -> Iterator[Move | Dwell]:
        """Yield what happens; note which moves go on with the circle before."""
        for event in events:
            if isinstance(event, Move):
                self._segments.append(event.segment)
            yield event

    def _noted(self, moves: Iterable[Timed | Dwell]) -> Iterator[Timed | Dwell]:
        """Yield the moves, noted for the report; what a smooth motor cannot do is refused."""
        smooth = _SmoothRules(self.name, self.setup)
        last: Timed | None = None
        for item in moves:
            if isinstance(item, Timed):
                smooth.move(item)
                self.report.add_move(item, self._segments.popleft())
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
