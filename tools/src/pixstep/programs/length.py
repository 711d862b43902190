# SPDX-License-Identifier: MIT
"""How long a plan may be that becomes files: no longer than what reads a line file takes."""

from collections.abc import Iterable, Iterator
from itertools import chain, pairwise

import numpy as np

from pixstep.errors import RefusedError
from pixstep.formats.records import CRLF, CSV_COLUMNS, MAX_BYTES
from pixstep.programs import language
from pixstep.programs.language import ProgramError
from pixstep.programs.motors import Setup
from pixstep.programs.moves import Dwell, Move, Program
from pixstep.programs.options import MODE1, Options
from pixstep.programs.pixels import Counts
from pixstep.programs.plan import Plan

_END = Dwell(0, 0.0)
MOST_PIXELS = MAX_BYTES // (CSV_COLUMNS.width + len(CRLF))
_ADVICE = (
    f"a line file holds {MOST_PIXELS}: run the program as it is, which takes any length (`pixstep "
    f"board run`, from Python run_program), or divide it"
)


def require(name: str, text: Iterable[str], setup: Setup, options: Options) -> None:
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
    events: Iterable[Move | Dwell], setup: Setup
) -> Iterator[tuple[Move | Dwell, float]]:
    """Yield what a program does with a time, ms, that each takes at least.

    A move is no faster than its motors in what is left of it between two blends.
    """
    places = np.zeros(len(setup.motors))
    fastest = np.array([motor.planned_speed(setup.pixel_ms) for motor in setup.motors])
    for event, following in pairwise(chain(events, (_END,))):
        if not isinstance(event, Move):
            yield event, event.ms
            continue
        target = np.array(event.target)
        least = float(np.max(np.abs(target - places) / fastest))
        places = target
        blend = following.ta if isinstance(following, Move) else event.ta
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
