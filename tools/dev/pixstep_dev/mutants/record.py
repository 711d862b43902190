# SPDX-License-Identifier: MIT
"""A campaign as a part of docs/MUTANTS.md: what killed how many, and every survivor."""

from collections import Counter
from collections.abc import Callable
from pathlib import PurePosixPath

from pixstep_dev.markdown import table
from pixstep_dev.mutants import judged
from pixstep_dev.mutants.campaign import EQUIVALENT, INVALID, SURVIVED, MutantsOutcome, MutantTrial
from pixstep_dev.mutants.judged import Judgements
from pixstep_dev.mutants.operators import KINDS
from pixstep_dev.mutants.stages import NAMES

NAME = "mutants"
_FATES = (*NAMES, "timeout", EQUIVALENT, SURVIVED)


def summary(outcome: MutantsOutcome, judgements: Judgements) -> str:
    """Return the figures in a sentence or two."""
    score = judged.score(outcome, judgements)
    valid = sum(trial.fate != INVALID for trial in outcome.trials)
    return (
        f"{valid:,} mutants of {outcome.offered:,} (seed {outcome.plan.seed}): {score.killed:,} "
        f"killed, {score.same_code:,} make the same object code, {score.equivalent:,} are judged "
        f"equivalent, {score.unseen:,} not seen, {score.open:,} not judged. Of the "
        f"{score.differing:,} that differ {100 * score.share:.1f} % are killed."
    )


def markdown(outcome: MutantsOutcome, judgements: Judgements) -> str:
    """Return the part: figures, what killed how many, by file; the survivors."""
    paragraphs = [
        summary(outcome, judgements),
        f"Beside these {outcome.counts()[INVALID]:,} did not compile.",
        _by("kind", KINDS, outcome, lambda trial: trial.mutant.kind),
        _by("file", _files(outcome), outcome, lambda trial: trial.mutant.file),
        *(_sort(title, outcome, judgements, verdict) for title, verdict in _SORTS),
    ]
    return "\n".join(f"{paragraph.strip()}\n" for paragraph in paragraphs if paragraph)


def _files(outcome: MutantsOutcome) -> tuple[str, ...]:
    return tuple(sorted({trial.mutant.file for trial in outcome.trials}))


def _by(
    what: str, keys: tuple[str, ...], outcome: MutantsOutcome, key_of: Callable[[MutantTrial], str]
) -> str:
    counts = Counter((key_of(trial), trial.fate) for trial in outcome.trials)
    rows = [
        (_short(key), *(_number(counts[key, fate]) for fate in _FATES))
        for key in keys
        if any(counts[key, fate] for fate in _FATES)
    ]
    rows.append(("all", *(_number(outcome.counts()[fate]) for fate in _FATES)))
    heads = {EQUIVALENT: "same code"}
    return table((what, *(heads.get(fate, fate) for fate in _FATES)), rows)


def _number(number: int) -> str:
    return f"{number:,}" if number else ""


def _short(key: str) -> str:
    return f"`{key.removeprefix('firmware/')}`" if "/" in key else key


_SORTS = (
    ("Survivors that are equivalent", judged.EQUIVALENT),
    ("Survivors that no test sees", judged.UNSEEN),
    ("Survivors that are not judged", None),
)


def _sort(title: str, outcome: MutantsOutcome, judgements: Judgements, verdict: str | None) -> str:
    """Return a list of the survivors of one sort."""
    lines = []
    for trial in outcome.survivors:
        judgement = judged.of(judgements, trial.mutant)
        if (judgement.verdict if judgement else None) == verdict:
            lines.append(_entry(trial, judgement.why if judgement else ""))
    return "\n".join([f"### {title}", "", *lines]) if lines else ""


def _entry(trial: MutantTrial, why: str) -> str:
    mutant = trial.mutant
    name = PurePosixPath(mutant.file).name
    where = f"`{name}`, {mutant.inside}()" if mutant.inside else f"`{name}`"
    change = f"* {where}: `{mutant.was}` becomes `{mutant.becomes}`"
    return f"{change}\n  {why}" if why else change
