# SPDX-License-Identifier: MIT
"""What is known of mutants that no test kills: a kept table, by function and by what lines say.

An entry says `equivalent`, with the reason why behaviour cannot differ, or `unseen`, with what no
test looks at. A line that changes makes its entries void: the mutant must be judged anew.
"""

import tomllib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from pixstep.errors import UserError
from pixstep_dev.mutants.campaign import MutantsOutcome
from pixstep_dev.mutants.operators import Mutant

TABLE = Path(__file__).resolve().parents[1] / "data" / "mutants.toml"
EQUIVALENT = "equivalent"
UNSEEN = "unseen"


@dataclass(frozen=True)
class MutantJudgement:
    """What somebody found out about a mutant."""

    verdict: str
    why: str


Judgements = dict[tuple[str, str, str, str], MutantJudgement]


def read(path: Path = TABLE) -> Judgements:
    """Return the kept judgements; raises UserError for a table that is not one."""
    try:
        entries = tomllib.loads(path.read_text(encoding="utf-8")).get("judged", [])
        found = {}
        for entry in entries:
            place = entry["file"], entry["inside"], entry["was"], entry["becomes"]
            if entry["verdict"] not in (EQUIVALENT, UNSEEN) or not entry["why"] or place in found:
                raise UserError(f"{path}: {entry['file']}: {entry['was']!r}: no judgement")
            found[place] = MutantJudgement(entry["verdict"], entry["why"])
        return found
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, KeyError, TypeError) as error:
        raise UserError(f"{path}: {error}") from None


def key(mutant: Mutant) -> tuple[str, str, str, str]:
    """Return what a mutant is known by, as long as its line stays as it is."""
    return mutant.file, mutant.inside, mutant.was, mutant.becomes


def of(judgements: Judgements, mutant: Mutant) -> MutantJudgement | None:
    """Return the judgement of a mutant, if there is one."""
    return judgements.get(key(mutant))


def equivalent(judgements: Judgements, mutant: Mutant) -> bool:
    """Whether a mutant is judged to behave as what it was made of."""
    found = of(judgements, mutant)
    return found is not None and found.verdict == EQUIVALENT


@dataclass(frozen=True)
class Score:
    """How many mutants there are of each sort; `share` is killed by those that differ."""

    killed: int
    same_code: int
    equivalent: int
    unseen: int
    open: int  # not judged

    @property
    def differing(self) -> int:
        """Return the mutants whose behaviour differs, for all that is known."""
        return self.killed + self.unseen + self.open

    @property
    def share(self) -> float:
        """Return the part of them that is killed."""
        return self.killed / self.differing if self.differing else 1.0


def score(outcome: MutantsOutcome, judgements: Judgements) -> Score:
    """Count an outcome's mutants."""
    sorts: Counter[str] = Counter()
    for trial in outcome.survivors:
        judgement = of(judgements, trial.mutant)
        sorts[judgement.verdict if judgement else "open"] += 1
    return Score(
        sum(trial.killed for trial in outcome.trials),
        outcome.counts()["equivalent"],
        sorts[EQUIVALENT],
        sorts[UNSEEN],
        sorts["open"],
    )
