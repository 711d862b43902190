# SPDX-License-Identifier: MIT
"""A fast move on a simulated board: every edge against the plan, and where it ends."""

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from pixstep.lines import units
from pixstep.moves.accel import Acceleration
from pixstep.moves.fast import FastMove
from pixstep.progress import Progress, unseen
from pixstep.simulation.judge import Judgement, judge
from pixstep.simulation.simrun import Job, RunResult, run_job
from pixstep.simulation.summary import Move, Summary


@dataclass(frozen=True)
class MoveJob:
    """A move and the board and axis that make it."""

    profile: Acceleration
    move: FastMove
    board: str
    axis: int
    pixel_hz: Fraction
    scale: units.Scale | None = None  # of the motor, if a machine file gives it


@dataclass(frozen=True)
class MoveRun:
    """What a simulated move left behind."""

    job: MoveJob
    result: RunResult
    judged: Judgement


def run(job: MoveJob, progress: Progress = unseen, *, out: Path) -> MoveRun:
    """Simulate and judge a move; leave edges, clock, serial (.csv) in `out`.

    The verdict is that of a line, and besides: the board's position register and the simulator's
    own count of the STEP edges must both be the steps asked for.
    """
    line = job.move.line()
    result = run_job(Job(job.board, {job.axis: line}, job.pixel_hz), out, progress)
    judged = judge(result)
    _judge_end(job, result, judged.summary)
    return MoveRun(job, result, judged)


def plan_summary(job: MoveJob) -> Move:
    """Return the plan as plain data."""
    move = job.move
    return {
        "steps": move.steps,
        "pixels": move.pixels,
        "seconds": round(move.seconds(job.pixel_hz), 6),
        "top_steps_px": move.top,
        "top_steps_s": round(float(move.top * job.pixel_hz), 3),
        "runs": [list(run) for run in move.runs],
    }


def _judge_end(job: MoveJob, result: RunResult, summary: Summary) -> None:
    """Compare where the board and the simulator say the axis is with the steps asked for."""
    counted = result.stats["boards"][0]["axes"][job.axis]["steps_signed"]
    position = result.axis_states.get(job.axis, {}).get("position_steps")
    summary["move"] = {
        **plan_summary(job),
        "position_register_steps": position,
        "counted_steps": counted,
        "moved_s": _seconds(result, job.axis),
    }
    wanted = 0 if result.refused else job.move.steps
    found = []
    if counted != wanted:
        found.append(f"the simulator counts {counted} steps, not {wanted}")
    if not result.refused and position != wanted:
        found.append(f"the position register says {position}, not {wanted}")
    if found:
        summary["reasons"] += found
        summary["verdict"] = "refused" if result.refused else "fail"


def _seconds(result: RunResult, axis: int) -> float | None:
    """Return the time from the first to the last STEP edge."""
    rising = result.edges.axis(0, axis).rising
    return round(float(rising[-1] - rising[0]) / result.job.tick_hz, 6) if len(rising) else None
