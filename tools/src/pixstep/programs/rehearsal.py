# SPDX-License-Identifier: MIT
"""A program planned once before anything moves: its mistakes are found at rest."""

from dataclasses import dataclass

from pixstep.board.capability import BoardLimits
from pixstep.errors import RefusedError
from pixstep.programs.plan import Plan
from pixstep.programs.report import Report
from pixstep.programs.wholecheck import WholeCheck
from pixstep.progress import Progress, unseen


@dataclass(frozen=True)
class Rehearsal:
    """What is known of a program once it has been planned to its end."""

    report: Report

    @property
    def pixels(self) -> int:
        """Length of the lines."""
        return self.report.pixels

    @property
    def ways(self) -> list[int]:
        """The direction in which each motor moves on the whole: all that a smooth one does."""
        return [(one.steps > 0) - (one.steps < 0) for one in self.report.motors]


def rehearse(plan: Plan, bounds: BoardLimits, progress: Progress = unseen) -> Rehearsal:
    """Plan a program to its end, every pixel checked by a board's limits.

    Raises UserError for a mistake in the program, RefusedError for what the board would refuse and
    for a plan that exceeds a limit.
    """
    motors = plan.setup.motors
    check = WholeCheck(motors, [bounds] * len(motors))
    for part in plan.counts():
        check.add(part)
        progress(0.0)
    for violation in plan.report.violations[:1]:
        raise RefusedError(
            f"{plan.name}:{violation.line}: exceeds the {violation.limit} of {violation.motor}: "
            f"{violation.ratio:.4g} x"
        )
    for motor, errors in zip(motors, check.end(), strict=True):
        for found in errors[:1]:
            raise RefusedError(
                f"{plan.name}: motor {motor.name}: line refused: {found.name} at pixel "
                f"{found.pixel}: {found.text} (nothing was sent)"
            )
    return Rehearsal(plan.report)
