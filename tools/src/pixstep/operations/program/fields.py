# SPDX-License-Identifier: MIT
"""How a motion program is planned, and for which motors of a machine file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pixstep.errors import UserError
from pixstep.lines.units import Quantity
from pixstep.machine import FILE_NAME, VARIABLE
from pixstep.operations.asked import AskedError
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE, Choice, Length, Number, Time, Whole
from pixstep.operations.request import Request, argument, option, shared_fields, unless
from pixstep.programs.plan_data import (
    LOOKAHEAD,
    MODE1,
    MODES,
    MOST_WINDOW,
    SEGMENT_MS,
    WINDOW,
    Options,
)

if TYPE_CHECKING:
    from pixstep.machine.files import MachineFile
    from pixstep.programs.motors import Setup


@shared_fields
class ProgramFields(Request):
    """A motion program and how it is planned."""

    program: Path = argument(FILE)
    mode: str = option(
        Choice(MODES), "lookahead never exceeds a limit; mode1 sees no more than two moves.",
        default=LOOKAHEAD,
    )  # fmt: skip
    window: int = option(Whole(1, MOST_WINDOW), "Moves that lookahead sees ahead.", default=WINDOW)
    assume_last: bool = unless(
        "mode1: do not time each move as if it were the last one; limits may be exceeded.",
        "--no-assume-last",
    )
    segment: float | None = option(
        Time("ms", *SEGMENT_MS), "Length of a circle's segments: 5ms.",
        default_text="program.segment_time of the machine file",
    )  # fmt: skip
    path_tolerance: float = option(
        Number(0.01, 1000),
        "Steps that a smooth motor may be off in a corner (1 at least), and segments on a circle, "
        "these half a step at most.",
        default=1.0,
    )  # fmt: skip
    arc_tolerance: Quantity | None = option(
        Length(),
        "How far an arc may leave a circle where its numbers are rounded: 2um, 0.5 steps.",
        default_text="a step of the finer motor",
    )  # fmt: skip

    def planned_for(self, desk: Desk) -> tuple[MachineFile, Setup, Options]:
        """Return the machine file, its motors, and how the program is to be planned.

        Raises UserError without a machine file, and for what the mode does not have.
        """
        machine = desk.facts.found
        if machine is None:
            raise AskedError(
                f"no machine file: {{machine}} FILE, {VARIABLE}, or {FILE_NAME} in this "
                f"folder (`pixstep machine new` begins one)"
            )
        setup = self._setup(machine)
        if not self.assume_last and self.mode != MODE1:
            raise AskedError(f"{{assume_last}}: only with {{mode}} {MODE1}")
        return machine, setup, Options(self.mode, self.window, self.assume_last)

    def _setup(self, machine: MachineFile) -> Setup:
        from pixstep.programs.motors import of_machine  # numpy takes a while to load
        from pixstep.programs.plan import with_segments

        setup = replace(of_machine(machine), path_tolerance=self.path_tolerance)
        if self.arc_tolerance is not None:
            steps = _finer_steps(machine, setup, self.arc_tolerance)
            setup = replace(setup, arc_tolerance=steps)
        return with_segments(setup, self.mode, self.segment)


def _finer_steps(machine: MachineFile, setup: Setup, length: Quantity) -> float:
    """Return a length in steps of the finer motor of a circle.

    Raises UserError for a length in mm or deg where no such motor has a scale for it.
    """
    chosen = [motor for motor in setup.motors if motor.word in ("X", "Y")]
    finer = max(chosen, key=lambda motor: motor.counts_per_unit, default=None)
    scale = machine[finer.name].steps_per_unit if finer else None
    try:
        return float(length.in_steps(scale).value)
    except UserError as error:
        raise AskedError("{arc_tolerance}: {error}", error=error) from None
