# SPDX-License-Identifier: MIT
"""A simulated fast move, what it left behind, and whether it ends where it has to."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from pixstep.lines import units
from pixstep.moves.fast import Acceleration, FastMove
from pixstep.simulation.job import RunResult
from pixstep.simulation.judge import Judgement
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

    def plan_summary(self) -> Move:
        """Return the plan as plain data."""
        move = self.move
        return {
            "steps": move.steps, "pixels": move.pixels,
            "seconds": round(move.seconds(self.pixel_hz), 6), "top_steps_px": move.top,
            "top_steps_s": round(float(move.top * self.pixel_hz), 3),
            "runs": [list(run) for run in move.runs],
        }  # fmt: skip


@dataclass(frozen=True)
class MoveRun:
    """What a simulated move left behind."""

    job: MoveJob
    result: RunResult
    judged: Judgement


def judge_end(job: MoveJob, result: RunResult, summary: Summary) -> None:
    """Compare where the board and the simulator say the axis is with the steps asked for."""
    counted = result.stats["boards"][0]["axes"][job.axis]["steps_signed"]
    position = result.axis_states.get(job.axis, {}).get("position_steps")
    rising = result.edges.axis(0, job.axis).rising
    moved_s = float(rising[-1] - rising[0]) / result.job.tick_hz if len(rising) else None
    summary["move"] = {
        **job.plan_summary(),
        "position_register_steps": position,
        "counted_steps": counted,
        "moved_s": None if moved_s is None else round(moved_s, 6),
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
