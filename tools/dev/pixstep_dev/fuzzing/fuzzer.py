# SPDX-License-Identifier: MIT
"""Running libFuzzer: one process, its progress, its figures, what it found."""

import re
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

from pixstep.errors import UserError
from pixstep.progress import Progress, unseen

TARGETS = ("server", "board")
INPUT_MAX = 256  # bytes: a few requests
_ARTIFACT = re.compile(r"Test unit written to (\S+)")
_COUNTERS = re.compile(r"\((\d+) inline 8-bit counters\)")
_PULSE = re.compile(r"#(\d+)\s.*?cov: (\d+) ft: (\d+) corp: (\d+)/")
_DONE = re.compile(r"stat::number_of_executed_units:\s*(\d+)")
_WORDS = re.compile(r"broken promise: .*|runtime error: .*|ERROR: AddressSanitizer: \S+")


@dataclass
class FuzzerOutcome:
    """What a run did. `finding` is empty if nothing was found, else what was said of it."""

    executions: int = 0
    edges: int = 0
    edges_known: int = 0
    features: int = 0
    inputs: int = 0
    finding: str = ""
    artifact: Path | None = None
    tail: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class FuzzLimits:
    """When a run ends: after so many executions or seconds (0: no such limit)."""

    executions: int = 0
    seconds: int = 0
    seed: int = 1

    def words(self) -> list[str]:
        """Return libFuzzer's options."""
        words = [f"-max_len={INPUT_MAX}", f"-seed={self.seed}", "-print_final_stats=1"]
        if self.executions:
            words.append(f"-runs={self.executions}")
        if self.seconds:
            words.append(f"-max_total_time={self.seconds}")
        return words


def run(
    program: Path,
    folder: Path,
    limits: FuzzLimits,
    progress: Progress = unseen,
) -> FuzzerOutcome:
    """Fuzz until a limit or a finding; `folder` holds the corpus, new inputs are added to it.

    What breaks a promise is kept in `artifacts` beside the folder. Raises UserError if the program
    cannot run.
    """
    artifacts = folder.parent / "artifacts"
    artifacts.mkdir(parents=True, exist_ok=True)
    words = [str(program), *limits.words(), f"-artifact_prefix={artifacts}/", str(folder)]
    outcome = FuzzerOutcome()
    try:
        process = subprocess.Popen(
            words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace"
        )
    except OSError as error:
        raise UserError(f"{program}: {error.strerror or error}") from None
    with process:
        assert process.stderr  # a pipe
        for line in process.stderr:
            _take(outcome, line.rstrip())
            if limits.executions:
                progress(min(1.0, outcome.executions / limits.executions))
    if process.returncode and not outcome.finding:
        outcome.finding = f"ended with status {process.returncode}: " + " / ".join(outcome.tail)
    return outcome


def merge(program: Path, folder: Path, into: Path, *, counters: bool) -> None:
    """Copy the inputs of `folder` that are needed to reach every edge of the program to `into`.

    With `counters` an edge that is passed more often counts as another one.
    """
    into.mkdir(parents=True, exist_ok=True)
    words = [program, "-merge=1", f"-use_counters={int(counters)}", into, folder]
    done = subprocess.run(
        [str(word) for word in words], capture_output=True, text=True, errors="replace", check=False
    )
    if done.returncode:
        raise UserError(f"{program}: merge: {done.stderr.strip().splitlines()[-1]}")


def _take(outcome: FuzzerOutcome, line: str) -> None:
    """Read one line of libFuzzer's."""
    outcome.tail = [*outcome.tail[-2:], line]
    if found := _PULSE.search(line):
        outcome.executions = max(outcome.executions, int(found[1]))
        outcome.edges, outcome.features, outcome.inputs = (int(found[n]) for n in (2, 3, 4))
    elif found := _COUNTERS.search(line):
        outcome.edges_known = int(found[1])
    elif found := _DONE.search(line):
        outcome.executions = int(found[1])
    elif found := _ARTIFACT.search(line):
        outcome.artifact = Path(found[1])
    elif (found := _WORDS.search(line)) and not outcome.finding:
        outcome.finding = found[0]
