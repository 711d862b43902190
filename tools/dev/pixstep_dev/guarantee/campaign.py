# SPDX-License-Identifier: MIT
"""Runs random sets of lines in the simulator and compares how they end with what was promised."""

import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from pixstep.board import guarantee
from pixstep.errors import UserError
from pixstep.progress import Progress, unseen
from pixstep.simulation import judge
from pixstep.simulation.job import LineExperiment, run_job
from pixstep_dev.guarantee.sets import SHARE, LineSet, random_set

CLEAN, REFUSED = "", "refused"
_OTHERS = ("no record of", "is more than 2 ticks off the clock's true edge")


@dataclass(frozen=True)
class GuaranteePlan:
    """So many sets from a seed on."""

    sets: int
    seed: int = 1
    boards: tuple[str, ...] = ()
    processes: int = 2


@dataclass(frozen=True)
class Ended:
    """A set, whether it was accepted, and how it ended."""

    set: LineSet
    accepted: bool
    end: str
    slack: float = 0.0


@dataclass
class GuaranteeOutcome:
    """All of them; `complaints` are accepted ones that did not run clean."""

    ended: list[Ended] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)


def attempt(seed: str, board: str | None = None) -> Ended:
    """Judge the set of a seed, and run it."""
    one = random_set(seed, board)
    late = guarantee.first_late(list(one.lines.values()), one.world)
    return Ended(one, late is None, run_set(one))


def run_set(one: LineSet) -> str:
    """Run a set; return how it ended."""
    return ending(one.job)


def ending(job: LineExperiment) -> str:
    """Run an experiment; return how it ended."""
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        try:
            result = run_job(job, Path(folder))
        except UserError as error:
            return f"{REFUSED} {error}"
        if result.refused:
            return f"{REFUSED} {result.refused.name}"
        if result.trouble:
            return result.trouble[0]
        reasons = judge.judge(result).summary["reasons"]
        # Records that were overwritten before they were read are no matter of the motion.
        # That a lock lets a last step be 2.1 ticks off is one of its precision.
        return "; ".join(text for text in reasons if not any(one in text for one in _OTHERS))


def run(plan: GuaranteePlan, progress: Progress = unseen) -> GuaranteeOutcome:
    """Run the sets of a plan."""
    outcome = GuaranteeOutcome()
    names = plan.boards or (None,)
    with ProcessPoolExecutor(plan.processes) as pool:
        waiting = [
            pool.submit(attempt, f"{plan.seed} {k}", names[k % len(names)])
            for k in range(plan.sets)
        ]
        for k, one in enumerate(waiting):
            ended = one.result()
            outcome.ended.append(ended)
            if ended.accepted and ended.end != CLEAN and not ended.end.startswith(REFUSED):
                outcome.complaints.append(f"{ended.set}: {ended.end}")
            progress((k + 1) / plan.sets)
    return outcome


def table(outcome: GuaranteeOutcome) -> list[str]:
    """Return a line for each board and kind: run clean, of those accepted.

    The last one is of sets at up to 120 % of what is guaranteed, the others' speeds reach further.
    """
    rows = ["board kind            sets refused  faults  clean accepted  share  accepted faults"]
    groups: dict[tuple[str, str], list[Ended]] = {}
    for one in outcome.ended:
        groups.setdefault((one.set.board, one.set.kind), []).append(one)
        groups.setdefault(("all", ""), []).append(one)
        if one.set.steps <= SHARE[1] * one.set.limit:
            groups.setdefault(("to", "120 %"), []).append(one)
    return rows + [_row(board, kind, found) for (board, kind), found in sorted(groups.items())]


def _row(board: str, kind: str, found: list[Ended]) -> str:
    refused = [one for one in found if one.end.startswith(REFUSED)]
    clean = [one for one in found if one.end == CLEAN]
    taken = [one for one in clean if one.accepted]
    faults = len(found) - len(refused) - len(clean)
    broken = [one for one in found if one.accepted and one.end and one not in refused]
    share = f"{len(taken) / len(clean):6.0%}" if clean else "     -"
    return (
        f"{board:<6}{kind:<14}{len(found):6}{len(refused):8}{faults:8}{len(clean):7}"
        f"{len(taken):9} {share} {len(broken):16}"
    )
