# SPDX-License-Identifier: MIT
"""What the commands that plan motion programs share: options, and the motors of a machine file."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, TypedDict

import click

from pixstep.cli.quantities import Decorated, FiniteRange, LengthType, TimeType
from pixstep.errors import UserError
from pixstep.lines.units import Quantity
from pixstep.machine import finding
from pixstep.programs.options import (
    LOOKAHEAD,
    MODE1,
    MODES,
    MOST_WINDOW,
    SEGMENT_MS,
    WINDOW,
    Options,
)

if TYPE_CHECKING:
    from pixstep.machine.reading import Machine
    from pixstep.programs.motors import Setup

_OPTIONS = (
    click.option(
        "--mode",
        type=click.Choice(MODES),
        default=LOOKAHEAD,
        show_default=True,
        help="lookahead never exceeds a limit; mode1 sees no more than two moves.",
    ),
    click.option(
        "--window",
        type=click.IntRange(1, MOST_WINDOW),
        default=WINDOW,
        show_default=True,
        help="Moves that lookahead sees ahead.",
    ),
    click.option(
        "--no-assume-last",
        is_flag=True,
        help="mode1: do not time each move as if it were the last one; limits may be exceeded.",
    ),
    click.option(
        "--segment",
        type=TimeType("ms", *SEGMENT_MS),
        help="Length of a circle's segments: 5ms.  "
        "[default: program.segment_time of the machine file]",
    ),
    click.option(
        "--path-tolerance",
        type=FiniteRange(0.01, 1000),
        default=1.0,
        show_default=True,
        help="Steps that a smooth motor may be off in a corner (1 at least), and segments on a "
        "circle, these half a step at most.",
    ),
    click.option(
        "--arc-tolerance",
        type=LengthType(),
        help="How far an arc may leave a circle where its numbers are rounded: 2um, 0.5 steps.  "
        "[default: a step of the finer motor]",
    ),
)
machine_option = click.option(
    "--machine",
    metavar="FILE",
    envvar=finding.VARIABLE,
    show_envvar=True,
    help=f"Machine file with motors and limits.  [default: {finding.NAME} in the current folder]",
)


class ProgramOptions(TypedDict):
    """What the options of planning give."""

    mode: str
    window: int
    no_assume_last: bool
    segment: float | None
    path_tolerance: float
    arc_tolerance: Quantity | None


def program_options(command: Decorated) -> Decorated:
    """Give a command the options of planning."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def read_machine(given: str | None) -> Machine:
    """Read the machine file that is given or found. Raises UserError if there is none."""
    from pixstep.machine.reading import Machine  # pydantic takes a while to load

    path = finding.find(given)
    if path is None:
        raise none_found()
    return Machine.load(path)


def none_found() -> UserError:
    """Return what is wrong where a machine file is missing."""
    return UserError(
        f"no machine file: --machine FILE, {finding.VARIABLE}, or {finding.NAME} in this "
        f"folder (`pixstep machine new` begins one)"
    )


def setup_of(machine: Machine, options: ProgramOptions) -> Setup:
    """Return the setup of a machine file and of the options."""
    from pixstep.programs.motors import of_machine
    from pixstep.programs.plan import with_segments

    setup = replace(of_machine(machine), path_tolerance=options["path_tolerance"])
    if options["arc_tolerance"] is not None:
        steps = _finer_steps(machine, setup, options["arc_tolerance"])
        setup = replace(setup, arc_tolerance=steps)
    return with_segments(setup, options["mode"], options["segment"])


def _finer_steps(machine: Machine, setup: Setup, length: Quantity) -> float:
    """Return a length in steps of the finer motor of a circle.

    Raises UserError for a length in mm or deg where no such motor has a scale for it.
    """
    chosen = [motor for motor in setup.motors if motor.word in ("X", "Y")]
    finer = max(chosen, key=lambda motor: motor.counts_per_unit, default=None)
    scale = machine[finer.name].steps_per_unit if finer else None
    try:
        return float(length.in_steps(scale).value)
    except UserError as error:
        raise UserError(f"--arc-tolerance: {error}") from None


def plan_options_of(options: ProgramOptions) -> Options:
    """Return how a program is to be planned. Raises UserError for what the mode does not have."""
    if options["no_assume_last"] and options["mode"] != MODE1:
        raise UserError(f"--no-assume-last: only with --mode {MODE1}")
    return Options(options["mode"], options["window"], not options["no_assume_last"])
