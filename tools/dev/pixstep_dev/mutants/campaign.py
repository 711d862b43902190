# SPDX-License-Identifier: MIT
"""A sample of mutants, each tried until something kills it."""

import hashlib
import json
import random
import re
import shutil
import tempfile
import threading
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from pixstep import natives
from pixstep.errors import UserError
from pixstep.progress import Progress, unseen
from pixstep_dev.mutants import assembly, operators, stages
from pixstep_dev.mutants.operators import Mutant
from pixstep_dev.mutants.programs import CannotBuildError, Workshop

Judged = Callable[[Mutant], bool]

INVALID = "invalid"  # does not compile
EQUIVALENT = "equivalent"  # compiles to the same object code
SURVIVED = "survived"


@dataclass(frozen=True)
class MutantsPlan:
    """So many mutants that compile, chosen by a seed from the files that `only` is found in.

    They are of the C sources, or of the assembly sources.
    """

    count: int
    seed: int = 1
    stages: tuple[str, ...] = stages.NAMES
    jobs: int = 2
    only: str = ""
    assembly: bool = False


@dataclass(frozen=True)
class MutantTrial:
    """A mutant and what became of it: a stage that killed it, timeout, or one of the names above.

    `by` is what killed it; `passed` are the stages that did not.
    """

    mutant: Mutant
    fate: str
    by: str = ""
    passed: tuple[str, ...] = ()

    @property
    def killed(self) -> bool:
        """Whether a test saw it."""
        return self.fate not in (INVALID, EQUIVALENT, SURVIVED)


@dataclass
class MutantsOutcome:
    """What became of a plan's mutants, in the order of the sample."""

    plan: MutantsPlan
    sources: str = ""  # digest of what was changed
    offered: int = 0  # mutants of all sources
    trials: list[MutantTrial] = field(default_factory=list)

    def counts(self) -> Counter[str]:
        """Return how many met which fate."""
        return Counter(trial.fate for trial in self.trials)

    @property
    def survivors(self) -> list[MutantTrial]:
        """Return what nothing has killed, by place."""
        found = [trial for trial in self.trials if trial.fate == SURVIVED]
        return sorted(found, key=lambda trial: (trial.mutant.file, trial.mutant.start))


def offered(paths: list[Path]) -> list[Mutant]:
    """Return every mutant of the sources."""
    root = natives.root()
    return [
        mutant
        for path in paths
        for mutant in _of_language(path)(
            str(path.relative_to(root)), path.read_text(encoding="utf-8")
        )
    ]


def _of_language(path: Path) -> Callable[[str, str], list[Mutant]]:
    return operators.mutants if path.suffix in (".c", ".h") else assembly.mutants


def digest(paths: list[Path]) -> str:
    """Return what says whether sources are the same."""
    found = hashlib.sha256()
    for path in paths:
        found.update(f"{path.relative_to(natives.root())}\n".encode() + path.read_bytes())
    return found.hexdigest()[:16]


class MutantsCampaign:
    """Trials of mutants, in folders of their own that are gone afterwards."""

    def __init__(self, plan: MutantsPlan, folder: Path, judged: Judged = lambda _: False) -> None:
        self.plan = plan
        self._judged = judged
        self.stages = stages.Stages(plan.stages, plan.assembly)
        self._folder = folder
        self._plain = Workshop(folder / "plain")
        self._own = threading.local()
        self._ended = threading.Event()

    def measure(self) -> None:
        """Run all that is tried by without a change."""
        for _ in self.stages.measure(self._plain):
            pass

    def end(self) -> None:
        """Begin no further trial and break off those that run."""
        self._ended.set()
        stages.end()

    def run(self, mutant: Mutant) -> MutantTrial | None:
        """Try a mutant; None if the campaign was ended."""
        if not hasattr(self._own, "workshop"):
            name = tempfile.mkdtemp(prefix="worker-", dir=self._folder)
            self._own.workshop = Workshop(Path(name))
        if self._ended.is_set():
            return None
        file = natives.root() / mutant.file
        workshop = self._own.workshop
        workshop.change(file, mutant.apply(file.read_text(encoding="utf-8")))
        try:
            trial = self._stages_of(mutant, workshop, file)
        except CannotBuildError:
            trial = MutantTrial(mutant, INVALID)
        finally:
            workshop.restore()
        return None if self._ended.is_set() else trial

    def _stages_of(self, mutant: Mutant, workshop: Workshop, file: Path) -> MutantTrial:
        passed: list[str] = []
        for stage in self.plan.stages:
            verdict = self.stages.try_stage(stage, workshop, file)
            if verdict:
                return MutantTrial(mutant, verdict.how, verdict.by, tuple(passed))
            passed.append(stage)
            if stage == "native":
                if self.stages.equivalent(workshop, self._plain, file):
                    return MutantTrial(mutant, EQUIVALENT, "", tuple(passed))
                if self._judged(mutant):
                    break
        return MutantTrial(mutant, SURVIVED, "", tuple(passed))


def run(
    plan: MutantsPlan,
    progress: Progress = unseen,
    kept: MutantsOutcome | None = None,
    judged: Judged = lambda _: False,
) -> MutantsOutcome:
    """Run a plan; with `kept`, an outcome of the same sources, only its survivors again.

    What is `judged` equivalent is tried by the native suites only. Raises UserError if something
    is not built, or fails without a change.
    """
    folder = natives.root() / "build" / "mutants"
    folder.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(prefix="run-", dir=folder))
    pool = ThreadPoolExecutor(plan.jobs)
    campaign = None
    try:
        campaign = MutantsCampaign(plan, work, judged)
        outcome = _begun(plan, kept)
        campaign.measure()
        _run_all(plan, campaign, pool, outcome, progress, kept)
        return outcome
    finally:
        if campaign:
            campaign.end()
        pool.shutdown(cancel_futures=True)
        shutil.rmtree(work)


def _begun(plan: MutantsPlan, kept: MutantsOutcome | None) -> MutantsOutcome:
    outcome = MutantsOutcome(plan, digest(_sources(plan)), len(offered(chosen(plan))))
    if not outcome.offered:
        raise UserError(f"no source has {plan.only!r} in its name")
    if kept and kept.sources != outcome.sources:
        raise UserError("the sources have changed since: run all of it again")
    return outcome


def _sources(plan: MutantsPlan) -> list[Path]:
    return stages.assembly_sources() if plan.assembly else stages.c_sources()


def chosen(plan: MutantsPlan) -> list[Path]:
    """Return the files that the plan draws from."""
    root = natives.root()
    return [path for path in _sources(plan) if re.search(plan.only, str(path.relative_to(root)))]


def _run_all(
    plan: MutantsPlan,
    campaign: MutantsCampaign,
    pool: ThreadPoolExecutor,
    outcome: MutantsOutcome,
    progress: Progress,
    kept: MutantsOutcome | None,
) -> None:
    """Fill the outcome: mutants in the order of the sample, until enough of them compile."""
    order = offered(chosen(plan))
    random.Random(plan.seed).shuffle(order)
    known = {trial.mutant: trial for trial in kept.trials} if kept else {}
    valid = 0
    while valid < plan.count and len(outcome.trials) < len(order):
        begin = len(outcome.trials)
        batch = order[begin : begin + plan.count - valid]
        for trial in pool.map(lambda one: _again(campaign, known.get(one), one), batch):
            if trial is None:  # the campaign was ended
                return
            outcome.trials.append(trial)
            valid += trial.fate != INVALID
            progress(valid / plan.count)


def _again(
    campaign: MutantsCampaign, known: MutantTrial | None, mutant: Mutant
) -> MutantTrial | None:
    """Return what is known of a mutant, unless it survived."""
    return known if known and known.fate != SURVIVED else campaign.run(mutant)


def facts(outcome: MutantsOutcome) -> dict[str, Any]:
    """Return plain data, from which `read` makes the outcome again."""
    return {
        "plan": asdict(outcome.plan),
        "sources": outcome.sources,
        "offered": outcome.offered,
        "trials": [asdict(trial) for trial in outcome.trials],
    }


def read(path: Path) -> MutantsOutcome:
    """Read what `facts` made; raises UserError."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        plan = {**data["plan"], "stages": tuple(data["plan"]["stages"])}
        return MutantsOutcome(
            MutantsPlan(**plan),
            data["sources"],
            data["offered"],
            [_trial(one) for one in data["trials"]],
        )
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}") from None
    except (ValueError, KeyError, TypeError):
        raise UserError(f"{path}: not what `pixstep-dev mutants --json` prints") from None


def _trial(data: dict[str, Any]) -> MutantTrial:
    mutant = Mutant(**data["mutant"])
    return MutantTrial(mutant, data["fate"], data["by"], tuple(data["passed"]))
