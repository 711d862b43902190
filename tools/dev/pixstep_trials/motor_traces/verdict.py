# SPDX-License-Identifier: MIT
"""Files of traces are judged: how many are equal, by kind, and where the others differ first."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pixstep.errors import PlainError, RefusedError
from pixstep_trials.motor_traces.compare import Difference
from pixstep_trials.motor_traces.replay import read, replay


@dataclass(frozen=True)
class Differing:
    """One trace that is not equal, and its first difference."""

    path: Path
    line: int
    kind: str
    difference: Difference

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.kind}: {self.difference}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        place = {"file": str(self.path), "line": self.line, "kind": self.kind}
        return place | vars(self.difference)


@dataclass
class TracesVerdict:
    """How many traces of each kind are equal and how many there are."""

    equal: dict[str, int] = field(default_factory=dict)
    total: dict[str, int] = field(default_factory=dict)
    differing: list[Differing] = field(default_factory=list)

    def add(self, kind: str, differing: Differing | None) -> None:
        """Count one trace."""
        self.total[kind] = self.total.get(kind, 0) + 1
        self.equal[kind] = self.equal.get(kind, 0) + (differing is None)
        if differing is not None:
            self.differing.append(differing)

    def lines(self) -> Iterator[str]:
        """Yield the figures, then the differing traces by kind."""
        width = max(map(len, [*self.total, "all"]))
        for kind, total in self.total.items():
            yield f"{kind:{width}}  {self.equal[kind]} of {total} equal"
        yield f"{'all':{width}}  {sum(self.equal.values())} of {sum(self.total.values())} equal"
        for one in sorted(self.differing, key=lambda one: one.kind):
            yield str(one)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data."""
        kinds = {kind: {"equal": self.equal[kind], "of": n} for kind, n in self.total.items()}
        return {
            "equal": sum(self.equal.values()),
            "of": sum(self.total.values()),
            "kinds": kinds,
            "differing": [one.to_dict() for one in self.differing],
        }


def judge(paths: Iterable[Path]) -> TracesVerdict:
    """Replay all traces of these files. RefusedError: a file holds something else."""
    verdict = TracesVerdict()
    for path in paths:
        for line, trace in enumerate(read(path), 1):
            try:
                difference = replay(trace)
            except PlainError as error:
                raise RefusedError(f"{path}:{line}: {error}") from None
            except (AttributeError, LookupError, TypeError, ValueError) as error:
                raise RefusedError(f"{path}:{line}: no trace: {error}") from None
            kind = str(trace["kind"])
            one = None if difference is None else Differing(path, line, kind, difference)
            verdict.add(kind, one)
    return verdict
