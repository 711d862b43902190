# SPDX-License-Identifier: MIT
"""A campaign of fuzzing: from the kept corpus on, and what of it is recorded."""

import shutil
import tempfile
from pathlib import Path

from pixstep import natives
from pixstep.errors import UserError
from pixstep.progress import Progress, unseen
from pixstep_dev import markdown
from pixstep_dev.fuzzing import corpus, fuzzer, sources

# What the kept corpus may grow to.
INPUTS_MAX = 190
BYTES_MAX = 40_000


def program(target: str) -> Path:
    """Return the built fuzzer of a target."""
    return natives.program(f"fuzz-{target}")


def run(
    target: str, limits: fuzzer.FuzzLimits, *, grow: bool = False, progress: Progress = unseen
) -> fuzzer.FuzzerOutcome:
    """Fuzz a target from its kept corpus on; with `grow` keep the inputs that reach more.

    An input that breaks a promise is left in a folder of its own under build/fuzz.
    """
    folder = natives.root() / "build" / "fuzz"
    folder.mkdir(parents=True, exist_ok=True)
    work = Path(tempfile.mkdtemp(prefix=f"{target}-", dir=folder))
    kept = corpus.path(target)
    corpus.unpack(corpus.read(kept) if kept.is_file() else [], work / "corpus")
    outcome = fuzzer.run(program(target), work / "corpus", limits, progress)
    if grow and not outcome.finding:
        _keep(target, work)
    if not outcome.finding:
        shutil.rmtree(work)
    return outcome


def _keep(target: str, work: Path) -> None:
    """Make what a run left the kept corpus: what every edge needs, and a choice of the rest."""
    found = {}
    for counters in (False, True):
        folder = work / f"minimal-{int(counters)}"
        fuzzer.merge(program(target), work / "corpus", folder, counters=counters)
        found[counters] = sorted(corpus.pack(folder), key=len)
    chosen = _spread(found[False], INPUTS_MAX)
    rest = [item for item in found[True] if item not in set(chosen)]
    chosen += _spread(rest, INPUTS_MAX - len(chosen))
    size = sum(map(len, chosen))
    if size > BYTES_MAX:
        raise UserError(
            f"{corpus.path(target)}: would hold {size} bytes; kept are at most {BYTES_MAX}"
        )
    corpus.write(corpus.path(target), chosen)


def _spread(inputs: list[bytes], most: int) -> list[bytes]:
    """Return at most `most` of the inputs, of every length."""
    return inputs[:: max(1, -(-len(inputs) // most))] if most > 0 else []


def plant(defect: sources.Defect, limits: fuzzer.FuzzLimits) -> tuple[fuzzer.FuzzerOutcome, int]:
    """Fuzz a target with a planted defect; return the outcome and the corpus' inputs."""
    kept = corpus.read(corpus.path(defect.target))
    with tempfile.TemporaryDirectory(prefix="pixstep-") as name:
        folder = Path(name)
        corpus.unpack(kept, folder / "corpus")
        built = sources.build_with(defect, folder / "build")
        return fuzzer.run(built, folder / "corpus", limits), len(kept)


def record(
    target: str, limits: fuzzer.FuzzLimits, outcome: fuzzer.FuzzerOutcome, path: Path
) -> None:
    """Write the facts of a campaign between the markers of its target."""
    kept = corpus.path(target)
    inputs = corpus.read(kept)
    with tempfile.TemporaryDirectory(prefix="pixstep-") as folder:
        covered = sources.coverage(target, kept, Path(folder))
    lines = sum(item.lines for item in covered)
    reached = sum(item.reached for item in covered)
    command = f"tools/pixstep-dev fuzz run {target} --executions {limits.executions}"
    facts = [
        ("command", f"`{command} --seed {limits.seed} --grow --record`"),
        ("executions", f"{outcome.executions:,}"),
        ("findings", outcome.finding or "none"),
        ("sanitizers", "address, undefined behaviour; clang's libFuzzer"),
        ("edges of the program reached", f"{outcome.edges:,} of {outcome.edges_known:,}"),
        ("inputs at the end; features", f"{outcome.inputs:,}; {outcome.features:,}"),
        (
            "kept corpus",
            f"{len(inputs)} inputs, {sum(map(len, inputs)):,} bytes ({kept.name})",
        ),
        ("firmware lines that the kept corpus reaches", f"{reached} of {lines}"),
        *((f"`{item.file}`", f"{item.reached} of {item.lines} lines") for item in covered),
    ]
    markdown.write(path, f"campaign {target}", markdown.table(("", target), facts))
