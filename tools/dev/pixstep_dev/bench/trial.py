# SPDX-License-Identifier: MIT
"""How a run ended: clean, refused, with a named fault, without an answer, or wrong.

Wrong is the one that must never be: an edge off its exact instant by a tick or more, missing,
doubled or in the wrong direction, and no fault said so before.
"""

from dataclasses import dataclass

from pixstep.simulation import verdict
from pixstep_dev.bench.drive import BenchDriveOutcome, BenchRun, drive

CLEAN, REFUSED, FAULT, MUTE, WRONG = "clean", "refused", "fault", "mute", "wrong"


@dataclass(frozen=True)
class BenchTrial:
    """How one run ended; `detail` names the line error, the fault or what was wrong."""

    kind: str
    detail: str = ""
    steps: int = 0

    @property
    def text(self) -> str:
        """Return the end in a few words."""
        return f"{self.kind} {self.detail}".strip()


def attempt(run: BenchRun) -> BenchTrial:
    """Run it and say how it ended."""
    return judge(drive(run))


def judge(outcome: BenchDriveOutcome) -> BenchTrial:
    """Return how a run ended, the exact instants of every line being the measure."""
    reasons = _reasons(outcome)
    if outcome.trouble and not outcome.steps:
        return BenchTrial(MUTE, outcome.trouble)
    if reasons:
        return BenchTrial(WRONG, "; ".join(reasons), outcome.steps)
    if outcome.refused:
        return BenchTrial(REFUSED, outcome.refused, outcome.steps)
    if outcome.fault:
        return BenchTrial(FAULT, outcome.fault, outcome.steps)
    if outcome.trouble:
        return BenchTrial(MUTE, outcome.trouble, outcome.steps)
    return BenchTrial(CLEAN, "", outcome.steps)


def _reasons(outcome: BenchDriveOutcome) -> list[str]:
    """Return what is wrong with the edges.

    A fault may cut a line short, and so may a refusal of what is streamed to a moving axis.
    """
    if outcome.refused and not outcome.steps:
        return []
    run = outcome.run
    reasons: list[str] = []
    zeros: set[int] = set()
    for axis, line in sorted(run.lines.items()):
        edges = outcome.edges.axis(0, axis)
        found = verdict.judge_axis(
            line,
            run.period,
            edges,
            axis,
            tick_hz=run.tick_hz,
            stopped=bool(outcome.fault or outcome.refused),
        )
        reasons += [f"axis {axis}: {text}" for text in found.reasons]
        known = verdict.find_zero(line, run.period, edges.rising) is not None  # else it is a guess
        if known and found.line_zero_cycle is not None:
            zeros.add(found.line_zero_cycle)
    if len(zeros) > 1:
        reasons.append(f"the axes do not share one line zero: cycles {sorted(zeros)}")
    elif zeros:
        _, reason = verdict.judge_clock(zeros.pop(), run.period, outcome.clock)
        reasons += [reason] if reason else []
    idle = set(outcome.edges.axes) - {(0, axis) for axis in run.lines}
    made = [axis for _, axis in sorted(idle) if len(outcome.edges.axis(0, axis).rising)]
    return reasons + [f"axis {axis} has no line and made steps" for axis in made]
