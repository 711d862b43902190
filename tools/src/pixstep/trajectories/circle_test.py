# SPDX-License-Identifier: MIT
"""The circle test on a simulated board: runs, files, verdict.

A table is run as it is, compensated, or both, one after the other; for each the measurement record
is written, and one picture has them all.
"""

import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NotRequired, TypedDict

from pixstep import atomic, outfolder
from pixstep.lines.units import hz_text
from pixstep.progress import Progress, unseen
from pixstep.trajectories import runs, table, transitions
from pixstep.trajectories.circle import COUNTS, Circle, RoundnessData, TableTrace, Unit
from pixstep.trajectories.runs import COMPENSATED, ORIGINAL, BoardJob, SimulatedTable
from pixstep.trajectories.table import TwoAxisTable
from pixstep.trajectories.transitions import TablePlay, Transition

RUNS = (ORIGINAL, COMPENSATED)
PICTURE = "circle.png"
SUMMARY = "summary.json"


class EdgeFigures(TypedDict):
    """How an axis made its edges."""

    steps: int
    expected_steps: int
    max_edge_error_ticks: float
    rms_edge_error_us: float
    pixels_equal: int


class RunSummary(TypedDict):
    """What is told of one run."""

    verdict: str
    cpu_share: float | None
    edges: list[EdgeFigures]
    max_load_error_counts: NotRequired[list[int]]
    roundness: NotRequired[RoundnessData]


class CircleSummary(TypedDict):
    """All figures of a test: summary.json."""

    verdict: str
    reasons: list[str]
    table: str
    board: str
    axes: list[int]
    pixel_hz: str
    play_steps: list[int]
    compensated_play_steps: list[int]
    transition_points: list[int]
    circle: dict[str, object] | None
    transitions: list[dict[str, object]]
    runs: dict[str, RunSummary]
    plots: NotRequired[list[str]]


@dataclass(frozen=True)
class CircleTest:
    """What to run: a table without hold records, its circle if it is one, the play to take up."""

    table: TwoAxisTable
    plays: tuple[TablePlay, ...]
    job: BoardJob
    circle: Circle | None = None
    unit: Unit = COUNTS
    runs: tuple[str, ...] = RUNS
    suffix: str = ".csv"  # of the measurement records


def names() -> list[str]:
    """Return the names of all files that a test may write."""
    return [SUMMARY, PICTURE, *(name + suffix for name in RUNS for suffix in (".csv", ".parquet"))]


def simulate(
    test: CircleTest, out: Path, *, plot: bool = False, progress: Progress = unseen
) -> CircleSummary:
    """Run a test; write summary.json, the measurement records and, if asked, the picture.

    All files or none. Raises RefusedError for what the board would refuse.
    """
    with outfolder.of_run(out, names()) as folder:
        runs = {}
        for number, name in enumerate(test.runs):
            runs[name] = _run(test, name, folder, _part(progress, number, len(test.runs)))
        summary = _summary(test, runs)
        traces = [run.trace for run in runs.values() if run.trace]
        if plot and traces:
            _draw(test, runs, traces, folder / PICTURE)
            summary["plots"] = [str(out / PICTURE)]
        atomic.write_json(folder / SUMMARY, summary)
    return summary


def _part(progress: Progress, number: int, runs: int) -> Progress:
    return lambda share: progress((number + share) / runs)


def _run(test: CircleTest, name: str, folder: Path, progress: Progress) -> SimulatedTable:
    """Make one run and write its measurement record; its logs, of every step, are not kept."""
    logs = Path(tempfile.mkdtemp(prefix=".logs-", dir=folder))
    try:
        done = runs.run_on_board(
            test.table, test.plays, name, test.job, logs, progress, test.circle
        )
    finally:
        shutil.rmtree(logs, ignore_errors=True)
    if done.trace:
        table.write_columns(folder / (name + test.suffix), done.trace.columns(test.circle))
    return done


def _draw(
    test: CircleTest, runs: dict[str, SimulatedTable], traces: Sequence[TableTrace], path: Path
) -> None:
    from pixstep.trajectories import picture  # matplotlib takes a second to load

    plays = " and ".join(str(play) for play in test.job.plays)
    steps = " and ".join(str(item.steps) for item in test.plays)
    below = (
        f"{test.table.name} on the simulated {test.job.board}, {float(test.job.pixel_hz):.6g} "
        f"points a second, play {plays} steps, taken up in {steps} points"
    )
    rounds = [run.roundness for run in runs.values() if run.roundness]
    if rounds:
        picture.draw(rounds, test.unit, below, path)
    else:
        picture.draw_errors(traces, test.unit, below, path)


def _summary(test: CircleTest, runs: dict[str, SimulatedTable]) -> CircleSummary:
    reasons = [f"{name}: {text}" for name, run in runs.items() for text in run.summary["reasons"]]
    made = transitions.compensate(test.table, test.plays)
    return {
        "verdict": "fail" if reasons else "pass",
        "reasons": reasons,
        "table": test.table.name,
        "board": test.job.board,
        "axes": list(test.job.axes),
        "pixel_hz": hz_text(test.job.pixel_hz).removesuffix("/1"),
        "play_steps": list(test.job.plays),
        "compensated_play_steps": [item.play for item in test.plays],
        "transition_points": [item.steps for item in test.plays],
        "circle": asdict(test.circle) if test.circle else None,
        "transitions": transitions_as_json(made.transitions),
        "runs": {name: _run_summary(run, test) for name, run in runs.items()},
    }


def transitions_as_json(found: Sequence[Transition]) -> list[dict[str, object]]:
    """Return transitions as plain data: axes and records count from 1."""
    return [asdict(item) | {"axis": item.axis + 1, "record": item.record + 1} for item in found]


def _run_summary(run: SimulatedTable, test: CircleTest) -> RunSummary:
    axes = sorted(run.summary["axes"], key=lambda axis: test.job.axes.index(axis["axis"]))
    found: RunSummary = {
        "verdict": run.summary["verdict"],
        "cpu_share": run.summary["cpu_share"],
        "edges": [
            {
                "steps": axis["steps"],
                "expected_steps": axis["expected_steps"],
                "max_edge_error_ticks": axis["max_edge_error_ticks"],
                "rms_edge_error_us": axis["rms_edge_error_us"],
                "pixels_equal": axis["pixels_equal"],
            }
            for axis in axes
        ],
    }
    if run.trace:
        errors = abs(run.trace.load_errors).max(axis=0).tolist()
        found["max_load_error_counts"] = [int(value) for value in errors]
    if run.roundness:
        found["roundness"] = run.roundness.summary(test.unit)
    return found
