# SPDX-License-Identifier: MIT
"""Random valid lines on a simulated board: the property test of the real image."""

import random
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pixstep.board import boards
from pixstep.progress import Progress, unseen
from pixstep.simulation.experiment import simulate
from pixstep.simulation.job import LineExperiment
from pixstep_trials import cases


@dataclass(frozen=True)
class RandomLinesPlan:
    """What to run: `lines` lines of each decode rule, `axes` of them at once."""

    board: str
    lines: int
    decodes: tuple[str, ...] = ("smooth", "plain")
    seed: int = 1
    min_interval_ticks: int = 533
    axes: int = 1
    serial_load: bool = False


def jobs(plan: RandomLinesPlan, decode: str) -> Iterator[LineExperiment]:
    """Yield the jobs of one decode rule; the same plan yields the same jobs."""
    bounds = cases.Bounds(
        min_interval_ticks=plan.min_interval_ticks, tick_hz=boards.load(plan.board).tick_hz
    )
    rng = random.Random(f"{plan.seed} {decode}")
    left = plan.lines
    while left:
        first = cases.case(rng, decode, bounds)
        lines = {0: first.line}
        while len(lines) < min(plan.axes, left):
            other = cases.case(rng, decode, bounds)
            if other.pixel_hz == first.pixel_hz:
                lines[len(lines)] = other.line
        left -= len(lines)
        yield LineExperiment(
            board=plan.board,
            lines=lines,
            pixel_hz=first.pixel_hz,
            serial_load=plan.serial_load,
            seed=plan.seed,
        )


def run(plan: RandomLinesPlan, progress: Progress = unseen) -> dict[str, Any]:
    """Run a plan and return its outcome as plain data."""
    results: list[dict[str, Any]] = []
    total = plan.lines * len(plan.decodes)
    for decode in plan.decodes:
        row: dict[str, Any] = {
            "decode": decode,
            "lines": 0,
            "passed": 0,
            "steps": 0,
            "max_edge_error_ticks": 0.0,
            "max_rms_edge_error_us": 0.0,
            "failures": [],
        }
        for job in jobs(plan, decode):
            _add(row, job)
            progress((sum(r["lines"] for r in results) + row["lines"]) / total)
        results.append(row)
    passed = all(row["passed"] == row["lines"] for row in results)
    return {"verdict": "pass" if passed else "fail", "plan": asdict(plan), "results": results}


def _add(row: dict[str, Any], job: LineExperiment) -> None:
    """Run one job and add it to the row of its decode rule."""
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        judged = simulate(job, Path(folder))
    count = len(job.lines)
    if judged.passed:
        row["passed"] += count
    else:
        row["failures"].append(
            {
                "index": row["lines"],
                "pixel_hz": str(job.pixel_hz),
                "lines": {axis: list(line.counts) for axis, line in job.lines.items()},
                "backlash": {axis: line.backlash for axis, line in job.lines.items()},
                "reasons": judged.summary["reasons"],
            }
        )
    row["lines"] += count
    for found in judged.axes:
        row["steps"] += found.steps
        row["max_edge_error_ticks"] = max(row["max_edge_error_ticks"], found.max_edge_error_ticks)
        row["max_rms_edge_error_us"] = max(row["max_rms_edge_error_us"], found.rms_edge_error_us)
