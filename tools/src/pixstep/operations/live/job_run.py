# SPDX-License-Identifier: MIT
"""A run of a job as the page of `pixstep watch --web` shows it: how far it is, the line's plan."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from pixstep.jobs.job import Job
from pixstep.jobs.report.story import Story
from pixstep.operations.live.eye import Eye

_MOST = 1000  # places of a line that a browser is told
_WRAP = 1 << 16  # of a board's count of lines


class LiveRun:
    """A run of a job; whoever reads its log sets `story`."""

    def __init__(self, name: str, job: Job, story: Story) -> None:
        self.name, self.job, self.story = name, job, story

    @property
    def verdict(self) -> tuple[str, str]:
        """The colour of the run, and how it is in a sentence."""
        return self.story.verdict

    def as_json(self) -> dict[str, Any]:
        """Return how far the run is."""
        story = self.story
        return {
            "name": self.name, "state": story.state, "lines": self.job.lines,
            "printed": story.printed, "pixels": self.job.pixels, "left_s": round(story.left_s, 1),
        }  # fmt: skip

    def plan(self, eyes: Sequence[Eye]) -> dict[str, Any]:
        """Return where each motor is to be in the line that moves, or that comes next."""
        return _plan(self.job, self._line(eyes))

    def _line(self, eyes: Sequence[Eye]) -> int:
        """Return the line that moves: by the boards' counts, which are ahead of the log."""
        told = self.story.told
        found = min(told.next_line, self.job.lines)
        if self.story.state != "running" or not told.chain:
            return found
        done = {
            name.motor: seen.now.axes[axis]["lines_done"]
            for eye in eyes for (unit, axis), name in eye.spot.names.items()
            if (seen := eye.seen.get(unit)) and seen.now and axis < len(seen.now.axes)
        }  # fmt: skip
        counts = [
            (done[motor] - base.lines_done) % _WRAP
            for motor, base in told.bases.items() if motor in done
        ]  # fmt: skip
        if not counts or min(counts) > self.job.lines:
            return found
        return min(told.chain + min(counts), self.job.lines)


@lru_cache(maxsize=4)
def _plan(job: Job, line: int) -> dict[str, Any]:
    motors = {}
    for motor, run in job.runs_of(line).items():
        places = [run.start_steps, *job.expected(line, motor)]
        last = len(places) - 1
        count = min(last, _MOST)
        pixels = [round(at * last / count) for at in range(count + 1)]
        motors[motor] = [[pixel, places[pixel]] for pixel in pixels]
    return {"line": line, "motors": motors}
