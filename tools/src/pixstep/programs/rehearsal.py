# SPDX-License-Identifier: MIT
"""A program planned once before anything moves: its mistakes are found at rest."""

from dataclasses import dataclass

import numpy as np

from pixstep.board.limits import BoardLimits
from pixstep.errors import RefusedError
from pixstep.programs import results
from pixstep.programs.pixels import Counts
from pixstep.programs.plan import Plan
from pixstep.programs.report import Report
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
    """Plan a program to its end; the first MOST_KEPT pixels are checked by a board's limits.

    Raises UserError for a mistake in the program, RefusedError for what the board would refuse and
    for a plan that exceeds a limit.
    """
    kept: list[Counts] = []
    room = results.MOST_KEPT
    for part in plan.counts():
        if room > 0:
            kept.append(part[:room].astype(np.int32))
            room -= len(part)
        progress(0.0)
    for violation in plan.report.violations[:1]:
        raise RefusedError(
            f"{plan.name}:{violation.line}: exceeds the {violation.limit} of {violation.motor}: "
            f"{violation.ratio:.4g} x"
        )
    counts = np.vstack(kept)
    for index, motor in enumerate(plan.setup.motors):
        for found in results.errors(motor, counts[:, index].tolist(), bounds, motor.name)[:1]:
            raise RefusedError(
                f"{plan.name}: motor {motor.name}: line refused: {found.name} at pixel "
                f"{found.pixel}: {found.message} (nothing was sent)"
            )
    return Rehearsal(plan.report)
