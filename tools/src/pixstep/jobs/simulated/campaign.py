# SPDX-License-Identifier: MIT
"""All blocks of a job, each different one once; those that are finished are not repeated."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field

from pixstep.errors import UserError, one_line
from pixstep.jobs.job import Job
from pixstep.jobs.simulated import cuts
from pixstep.jobs.simulated.crews import Crew, LostError
from pixstep.jobs.simulated.cuts import Cut, Cutter, SimulatedWorld, Tools
from pixstep.jobs.simulated.folder import SimFolder
from pixstep.jobs.simulated.work import Answer
from pixstep.progress import Progress, unseen

_LOOK_S = 2.0
_TRIES = 3  # of a block whose process dies


@dataclass
class BlockCounts:
    """How many blocks there were: different ones, those simulated now, those known before."""

    blocks: int = 0
    different: int = 0
    simulated: int = 0
    known: int = 0
    repeated: int = 0  # blocks whose process had died


@dataclass
class Campaign:
    """The blocks of a job, in a world, on their way."""

    job: Job
    world: SimulatedWorld
    tools: Tools
    folder: SimFolder
    show: Progress = unseen
    counts: BlockCounts = field(default_factory=BlockCounts)

    def __post_init__(self) -> None:
        self._cutter = Cutter(self.job, self.world, self.tools)
        self._under_way: dict[Future[Answer], Cut] = {}
        self._deaths: Counter[str] = Counter()  # of processes, by the block that they had

    def cuts(self) -> Iterator[Cut]:
        """Yield the blocks."""
        return self._cutter.cuts()

    def missing(self) -> list[Cut]:
        """Return the blocks that are not finished, each different one once."""
        seen: dict[str, bool] = {}  # keys, and whether each was finished
        found = []
        for cut in self.cuts():
            self.counts.blocks += 1
            if cut.key not in seen:
                seen[cut.key] = self.folder.has(cut.key)
                if not seen[cut.key]:
                    found.append(cut)
        self.counts.different = len(seen)
        self.counts.known = sum(seen.values())
        return found

    def run(self, crew: Crew, missing: list[Cut]) -> None:
        """Simulate blocks. Raises UserError naming one that cannot be simulated."""
        left = missing[::-1]
        try:
            while left or self._under_way:
                while left and len(self._under_way) < crew.width:
                    self._submit(crew, left.pop())
                left += self._take(crew)
                done = self.counts.known + self.counts.simulated
                self.show(done / self.counts.different)
        finally:
            for future in self._under_way:
                future.cancel()

    def _submit(self, crew: Crew, cut: Cut) -> None:
        data = cuts.pack(self.job, cut, self.world, self.tools)
        self._under_way[crew.submit(data, str(self.folder.edges))] = cut

    def _take(self, crew: Crew) -> list[Cut]:
        """Keep what has come back; return the blocks that are to be simulated again."""
        began = time.monotonic()
        while not (done := wait(self._under_way, _LOOK_S, FIRST_COMPLETED).done):
            crew.look(time.monotonic() - began)
        errors = {future: error for future in done if (error := _error_of(future))}
        for future in done - errors.keys():
            self._keep(crew, self._under_way.pop(future), future.result())
        again = []
        for future, error in errors.items():
            cut = self._under_way.pop(future)
            if not isinstance(error, BrokenProcessPool):
                raise _refused(cut, error)
            again.append(cut)
        if again:
            crew.renew()
            again += self._under_way.values()
            self._under_way.clear()
        return self._again(again)

    def _again(self, cuts: list[Cut]) -> list[Cut]:
        """Count blocks whose process has died."""
        self.counts.repeated += len(cuts)
        for cut in cuts:
            self._deaths[cut.key] += 1
            if self._deaths[cut.key] >= _TRIES:
                raise UserError(
                    f"lines {cut.first} to {cut.last}: whoever simulated them has died {_TRIES} "
                    f"times: is there too little memory?"
                )
        return cuts

    def _keep(self, crew: Crew, cut: Cut, answer: Answer) -> None:
        if answer.refused:
            raise UserError(f"lines {cut.first} to {cut.last}: {answer.refused}")
        self.folder.keep(answer, local=crew.local)
        self.counts.simulated += 1


def _refused(cut: Cut, error: BaseException) -> UserError:
    """Return why a block has not come back."""
    if isinstance(error, CancelledError):
        return LostError("the scheduler is gone, or has taken the blocks back")
    why = one_line(str(error))
    return UserError(f"lines {cut.first} to {cut.last}: {type(error).__name__}: {why}")


def _error_of(future: Future[Answer]) -> BaseException | None:
    try:
        return future.exception()
    except CancelledError as error:
        return error
