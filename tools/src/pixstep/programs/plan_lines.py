# SPDX-License-Identifier: MIT
"""The lines of a plan: as queue entries, checked as a board does, rehearsed, written to a folder.

Each of these goes on while the program is planned. A program is rehearsed before anything moves, so
that its mistakes are found at rest. A folder gets a line file for each motor, all of equal length,
and the report.
"""

import re
from collections import deque
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from pixstep import atomic, outfolder
from pixstep.board.capability import BoardCapability
from pixstep.errors import RefusedError
from pixstep.formats.records import CSV_COLUMNS, LineEnds, join_records, number_texts
from pixstep.lines import line_check
from pixstep.lines.core import Checker, CoreFinding
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import IDLE_PIXEL, Finding
from pixstep.lines.runs import (
    MARK_END,
    MARK_NEGATIVE,
    MARK_SMOOTH,
    MARK_START,
    MARK_WAIT_FOR_EDGE,
    MAX_REPEAT,
    head_entries,
)
from pixstep.programs.motors import PlanMotor
from pixstep.programs.pixels import Counts
from pixstep.programs.plan import Plan, bounded
from pixstep.programs.plan_data import PlannedMotor, PlannedProgram, limit_text
from pixstep.programs.report import MotorReport, Report
from pixstep.progress import Progress, unseen

Entry = tuple[int, int]


def of_line(counts: Counts, motor: PlanMotor) -> Counts:
    """Return counts as a line file has them: a smooth line's are unsigned."""
    if motor.smooth:
        return np.abs(counts)
    return -counts if motor.negative else counts


class MotorEntries:
    """The queue entries of one motor that are planned and not taken yet."""

    def __init__(self, motor: PlanMotor, way: int) -> None:
        self.motor = motor
        self.divider: int | None = None  # that its line says
        self.way = way  # the direction in which the motor moves; 0 if it is not known yet
        self.pixels = 0  # of the entries that wait
        self.steps = 0  # of all that was planned, there and back
        self._runs: deque[Entry] = deque()
        self._begun = self._ended = False

    def add(self, counts: Counts) -> None:
        """Take the counts of some pixels."""
        total = int(counts.sum())
        self.way = self.way or (total > 0) - (total < 0)
        self.pixels += len(counts)
        self.steps += int(np.abs(counts).sum())
        line = of_line(counts, self.motor)
        starts = np.flatnonzero(np.diff(line, prepend=line[0] - 1))
        lengths = np.diff(starts, append=len(line))
        for count, repeat in zip(line[starts].tolist(), lengths.tolist(), strict=True):
            self._add(count, repeat)

    def _add(self, count: int, repeat: int) -> None:
        if self._runs and self._runs[-1][0] == count:
            repeat += self._runs.pop()[1]
        while repeat > MAX_REPEAT:
            self._runs.append((count, MAX_REPEAT))
            repeat -= MAX_REPEAT
        self._runs.append((count, repeat))

    @property
    def unknown(self) -> bool:
        """True while the entry that begins a line cannot be made."""
        return self.motor.smooth and not self.way

    def take(self, most: int, *, whole: bool, over: bool) -> list[Entry]:
        """Return up to so many entries; the last run only if it can grow no more, or not `whole`.

        `over` says that no more counts will come.
        """
        found = [] if self._begun else head_entries(self._mark(), (0, 0), self.divider)
        self._begun = True
        kept = 1 if whole and not over else 0
        while len(self._runs) > kept and len(found) < most:
            found.append(self._runs.popleft())
            self.pixels -= found[-1][1]
        if over and not self._runs and not self._ended:
            self._ended = True
            found.append((MARK_END, 0))
        return found

    def _mark(self) -> int:
        mark = MARK_START | MARK_WAIT_FOR_EDGE
        if self.motor.smooth:
            mark |= MARK_SMOOTH
            if (self.way < 0) != self.motor.negative:
                mark |= MARK_NEGATIVE
        return mark


_MOST_KEPT = 20  # errors of a motor that are kept, findings that are told
_ALL = 1 << 31  # more entries than there are


class WholeCheck:
    """The lines of all motors, each by the limits of its board; memory does not grow with them."""

    def __init__(self, motors: Sequence[PlanMotor], bounds: Sequence[BoardCapability]) -> None:
        self._lines = [MotorEntries(motor, 0) for motor in motors]
        self._checkers = [
            Checker(bound.of(Line((), SMOOTH if motor.smooth else PLAIN)).of_board())
            for motor, bound in zip(motors, bounds, strict=True)
        ]
        self._errors: list[list[CoreFinding]] = [[] for _ in motors]

    def add(self, counts: Counts) -> None:
        """Take the counts of some pixels, a column for each motor."""
        for index, line in enumerate(self._lines):
            line.add(counts[:, index])
            if not line.unknown:
                self._check(index, over=False)

    def end(self) -> list[list[CoreFinding]]:
        """Return the first errors of each motor's line, which is over."""
        for index, line in enumerate(self._lines):
            line.way = line.way or 1  # one that never moves may have either
            self._check(index, over=True)
        return self._errors

    def _check(self, index: int, *, over: bool) -> None:
        found = self._checkers[index].more(self._lines[index].take(_ALL, whole=True, over=over))
        errors = self._errors[index]
        # A line of counts does not tell the backlash, which an idle pixel is about.
        wrong = [code for code in found if code.is_error and code.name != IDLE_PIXEL]
        errors += wrong[: _MOST_KEPT - len(errors)]


def rehearse(plan: Plan, bounds: BoardCapability, progress: Progress = unseen) -> Report:
    """Plan a program to its end, every pixel checked by a board's limits; return what is known.

    Raises UserError for a mistake in the program, RefusedError for what the board would refuse and
    for a plan that exceeds a limit.
    """
    motors = plan.setup.motors
    check = WholeCheck(motors, [bounds] * len(motors))
    for part in plan.counts():
        check.add(part)
        progress(0.0)
    for bad in plan.report.violations[:1]:
        raise RefusedError(f"{plan.name}:{limit_text(bad)}")
    for motor, errors in zip(motors, check.end(), strict=True):
        for found in errors[:1]:
            raise RefusedError(
                f"{plan.name}: motor {motor.name}: line refused: {found.name} at pixel "
                f"{found.pixel}: {found.text} (nothing was sent)"
            )
    return plan.report


REPORT, PATH_PICTURE, MOTION_PICTURE = "report.json", "path.png", "motion.png"
_PLAIN_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")


@dataclass(frozen=True)
class PlannedFiles:
    """A plan that is written."""

    plan: Plan
    files: tuple[str, ...]
    counts: Counts
    findings: tuple[tuple[Finding, ...], ...]
    facts: PlannedProgram

    @property
    def fine(self) -> bool:
        """True if no limit is exceeded and the board would take every line."""
        return _fine(self.plan, self.findings)


def write(
    plan: Plan,
    out: Path,
    bounds: list[BoardCapability],
    *,
    plot: bool = False,
    progress: Progress = unseen,
) -> PlannedFiles:
    """Plan a program and write everything to a folder, all files or none.

    `bounds` are what each motor's board allows. Raises UserError for a mistake in the program, and
    for a plan that is longer than a line file.
    """
    names = [
        f"{motor.name if _PLAIN_NAME.fullmatch(motor.name) else motor.word}.csv"
        for motor in plan.setup.motors
    ]
    pictures = [PATH_PICTURE, MOTION_PICTURE]
    with outfolder.of_run(out, [*names, REPORT, *pictures]) as folder:
        check = WholeCheck(plan.setup.motors, bounds)
        counts = _write_lines(plan, folder, names, check, progress)
        columns = zip(plan.setup.motors, check.end(), counts.T, bounds, names, strict=True)
        found = tuple(
            tuple(line_errors(motor, column.tolist(), bound, name)) if refused else ()
            for motor, refused, column, bound, name in columns
        )
        files = [str(out / name) for name in names]
        facts = as_json(plan, files, found)
        atomic.write_json(folder / REPORT, facts)
        if plot:
            from pixstep.programs import figure  # matplotlib takes a second to load

            drawn = figure.Drawn(plan, counts)
            figure.save(drawn, folder / PATH_PICTURE, folder / MOTION_PICTURE)
            facts["plots"] = [str(out / name) for name in pictures]
    return PlannedFiles(plan, tuple(files), counts, found, facts)


def _write_lines(
    plan: Plan, folder: Path, names: list[str], check: WholeCheck, progress: Progress
) -> Counts:
    """Write the lines as they are planned, and check them; return their counts."""
    kept: list[Counts] = []
    row = 1
    with ExitStack() as stack:
        files = [stack.enter_context(_opened(folder / name)) for name in names]
        for part in bounded(plan):
            check.add(part)
            for index, (file, motor) in enumerate(zip(files, plan.setup.motors, strict=True)):
                with atomic.told_of(folder / names[index]):
                    counts = of_line(part[:, index], motor).tolist()
                    texts = number_texts(counts, CSV_COLUMNS, names[index], row)
                    file.write(join_records(texts, LineEnds()))
                    file.flush()
            row += len(part)
            kept.append(part.astype(np.int32))
            progress(0.0)
    return np.vstack(kept)


@contextmanager
def _opened(path: Path) -> Iterator[BinaryIO]:
    """Open a line file. Closing it writes again what did not fit, so that may fail as well."""
    with atomic.told_of(path), path.open("wb") as file:
        yield file


def line_errors(
    motor: PlanMotor, counts: list[int], bounds: BoardCapability, name: str
) -> list[Finding]:
    """Return why the board would refuse a line."""
    line = Line(
        tuple(map(abs, counts)) if motor.smooth else tuple(counts),
        SMOOTH if motor.smooth else PLAIN,
        name=name,
    )
    found = line_check.without_idle_pixel(line_check.check(line, bounds.of(line)))
    return [item for item in found if item.severity == line_check.ERROR]


def as_json(
    plan: Plan, files: Sequence[str], findings: Sequence[tuple[Finding, ...]]
) -> PlannedProgram:
    """Return everything that is known as plain data."""
    return {
        "program": plan.name,
        "mode": plan.options.mode,
        "window_moves": plan.options.window,
        "verdict": "fine" if _fine(plan, findings) else "exceeds limits",
        **plan.report.as_json(),  # type: ignore[typeddict-item]  # the plots come later
        "motors": [
            _motor_json(*item) for item in zip(plan.report.motors, files, findings, strict=True)
        ],
    }


def _fine(plan: Plan, findings: Sequence[tuple[Finding, ...]]) -> bool:
    return plan.report.whole and not any(findings)


def _motor_json(motor: MotorReport, path: str, found: tuple[Finding, ...]) -> PlannedMotor:
    backwards = (motor.steps < 0) != motor.motor.negative
    return {
        **motor.as_json(),
        "file": path,
        "direction": "-" if motor.motor.smooth and backwards else "+",
        "refused": line_check.as_json(list(found[:_MOST_KEPT])),
    }
