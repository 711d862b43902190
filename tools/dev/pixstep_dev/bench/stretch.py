# SPDX-License-Identifier: MIT
"""Views of chosen stretches: the steady part of a line, or a board at rest."""

from fractions import Fraction
from typing import Any

from pixstep.board.upload import LineUpload
from pixstep.errors import UserError
from pixstep.lines.line import Line
from pixstep.simulation.simulated_board import SerialLoad, SimulatedBoard
from pixstep_dev.bench.drive import BenchDriveOutcome, BenchRun, RunWindow, drive, view

_MARGIN = 0.05  # of a line's steps, left out at either end


def inside(line: Line, begin: int = 0, end: int = 0) -> RunWindow:
    """Return the window from pixel `begin` to `end` pixels before the last, less a margin."""
    first = sum(abs(count) for count in line.counts[:begin])
    last = sum(abs(count) for count in line.counts[: line.pixels - end])
    margin = int(_MARGIN * (last - first))
    return RunWindow(first + margin, last - margin)


def moving(
    board: str, line: Line, hz: Fraction, window: RunWindow, *, axes: int = 1, **options: Any
) -> dict[str, Any]:
    """Return the view of a window while `axes` axes run the same line.

    Raises UserError if the run ends before: the board cannot do this line.
    """
    run = BenchRun(board, dict.fromkeys(range(axes), line), hz, windows=(window,), **options)
    outcome = drive(run)
    _refuse_cut_short(outcome)
    if not outcome.views:
        raise UserError(f"{board}, {axes} axes, {line.name}: too short for its window")
    return outcome.views[0] | {"stack_used_bytes": outcome.stats["boards"][0]["stack_used_bytes"]}


def whole(board: str, line: Line, hz: Fraction) -> dict[str, Any]:
    """Return the handlers of a whole run of one axis, and its steps."""
    outcome = drive(BenchRun(board, {0: line}, hz))
    _refuse_cut_short(outcome)
    rows = outcome.stats["boards"][0]["handlers"]
    return {"handlers": {row["name"]: row for row in rows}, "steps": outcome.steps}


def _refuse_cut_short(outcome: BenchDriveOutcome) -> None:
    """Raise UserError for a run that the board did not bring to its end."""
    why = outcome.refused or outcome.fault or outcome.trouble
    if why:
        axes, line = len(outcome.run.lines), next(iter(outcome.run.lines.values()))
        raise UserError(f"{outcome.run.board}, {axes} axes, {line.name}: {why}")


def at_rest(
    board: str, hz: Fraction, seconds: float, *, serial_load: bool = False
) -> dict[str, Any]:
    """Return the view of an enabled board without a line."""
    with SimulatedBoard(board, hz) as run:
        run.set_up(hz, [0])
        simulator = run.simulator
        uploads = {0: LineUpload(run.board, 0, [])}
        load = SerialLoad(run.board, [0], uploads) if serial_load else None
        before = simulator.stats() | {"made": 0}
        simulator.mark()
        end = simulator.cycle + int(seconds * simulator.tick_hz)
        while simulator.cycle < end:
            if load:
                load.until(simulator, end)
            else:
                simulator.run(end - simulator.cycle)
        return view(before, simulator.stats() | {"made": 0})
