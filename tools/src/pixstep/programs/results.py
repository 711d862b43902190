# SPDX-License-Identifier: MIT
"""A plan into a folder: a line file for each motor, all of equal length, and the report."""

import re
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from pixstep import atomic, outfolder
from pixstep.board.limits import BoardLimits
from pixstep.formats.records import CSV_COLUMNS, LineEnds, join_records, number_texts
from pixstep.lines import line_check
from pixstep.lines.line import PLAIN, SMOOTH, Line
from pixstep.lines.line_check import Finding
from pixstep.programs import length
from pixstep.programs.entries import of_line
from pixstep.programs.figures import PlannedMotor, PlannedProgram
from pixstep.programs.motors import PlanMotor
from pixstep.programs.pixels import Counts
from pixstep.programs.plan import Plan
from pixstep.programs.report import MotorReport
from pixstep.programs.wholecheck import WholeCheck
from pixstep.progress import Progress, unseen

REPORT, PATH_PICTURE, MOTION_PICTURE = "report.json", "path.png", "motion.png"
_PLAIN_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")


@dataclass(frozen=True)
class Result:
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


def file_name(motor: PlanMotor) -> str:
    """Return the name of a motor's line file."""
    name = motor.name if _PLAIN_NAME.fullmatch(motor.name) else motor.word
    return f"{name}.csv"


def write(
    plan: Plan,
    out: Path,
    bounds: list[BoardLimits],
    *,
    plot: bool = False,
    progress: Progress = unseen,
) -> Result:
    """Plan a program and write everything to a folder, all files or none.

    `bounds` are what each motor's board allows. Raises UserError for a mistake in the program, and
    for a plan that is longer than a line file.
    """
    names = [file_name(motor) for motor in plan.setup.motors]
    pictures = [PATH_PICTURE, MOTION_PICTURE]
    with outfolder.of_run(out, [*names, REPORT, *pictures]) as folder:
        check = WholeCheck(plan.setup.motors, bounds)
        counts = _write_lines(plan, folder, names, check, progress)
        found = tuple(
            tuple(errors(motor, counts[:, index].tolist(), bounds[index], names[index]))
            if refused
            else ()
            for index, (motor, refused) in enumerate(
                zip(plan.setup.motors, check.end(), strict=True)
            )
        )
        files = [str(out / name) for name in names]
        facts = as_json(plan, files, found)
        atomic.write_json(folder / REPORT, facts)
        if plot:
            from pixstep.programs import figure  # matplotlib takes a second to load

            drawn = figure.Drawn(plan, counts)
            figure.save(drawn, folder / PATH_PICTURE, folder / MOTION_PICTURE)
            facts["plots"] = [str(out / name) for name in pictures]
    return Result(plan, tuple(files), counts, found, facts)


def _write_lines(
    plan: Plan, folder: Path, names: list[str], check: WholeCheck, progress: Progress
) -> Counts:
    """Write the lines as they are planned, and check them; return their counts."""
    kept: list[Counts] = []
    row = 1
    with ExitStack() as stack:
        files = [stack.enter_context(_opened(folder / name)) for name in names]
        for part in length.bounded(plan):
            check.add(part)
            for index, (file, motor) in enumerate(zip(files, plan.setup.motors, strict=True)):
                with atomic.told_of(folder / names[index]):
                    file.write(_records(of_line(part[:, index], motor), names[index], row))
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


def _records(counts: Counts, name: str, first: int) -> bytes:
    return join_records(number_texts(counts.tolist(), CSV_COLUMNS, name, first), LineEnds())


def errors(motor: PlanMotor, counts: list[int], bounds: BoardLimits, name: str) -> list[Finding]:
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
        "refused": line_check.as_json(list(found[:MOST_FINDINGS])),
    }


MOST_FINDINGS = 20
