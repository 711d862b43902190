# SPDX-License-Identifier: MIT
"""A run of a job as it goes on."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

from pixstep import atomic, signals
from pixstep.errors import FINE, NEGATIVE
from pixstep.operations.desk import Desk
from pixstep.operations.job import report
from pixstep.operations.job.reading import opened, run_folder
from pixstep.operations.kinds import OUTPUT, Time
from pixstep.operations.request import Request, flag, operation, option
from pixstep.operations.result import Result

if TYPE_CHECKING:
    from pixstep.jobs.report.story import Story

_PAGE_S = 2.0  # the file of a report is not written more often


class WatchedRun(TypedDict):
    """A run at one moment: `line` is the one that moves, or that comes next."""

    run: str
    state: str
    line: int
    lines: int
    printed: int
    left_s: float
    text: str


class WatchedRuns(TypedDict):
    """A run at each change that was seen."""

    looks: list[WatchedRun]


@operation("watch")
class WatchRun(Request):
    """Watch a run of a job: the line that moves, and the time that is left.

    It reads the run's log; no board is asked, so it may run beside `job run`. It ends with the run,
    or by Ctrl-C. Exit status 0; 1 if the run was broken off.
    """

    result = WatchedRuns
    json_rows = "change"

    run_path: Path = run_folder()
    interval: float = option(
        Time("s", 0.05, 3600), "Time from one look to the next.", default=0.5, default_text="0.5s"
    )
    once: bool = flag("Look once.")
    page: Path | None = option(
        OUTPUT, "HTML file: the report of the run, written anew as it goes on.", shown="FILE"
    )

    def run(self, desk: Desk) -> Result:
        """Look until the run has ended, or Ctrl-C comes."""
        folder, job = opened(self.run_path)
        from pixstep.jobs.report.story import Story

        rows = desk.rows("looks")
        state, before, paged_s, is_stale = "running", "", -_PAGE_S, True
        with signals.until_ctrl_c(), desk.progress(str(self.run_path)) as show:
            while True:
                story = Story.of(folder, job)
                state = story.state
                show(len(story.told.printed) / job.lines)
                seen = _seen(self.run_path, story)
                key = f"{state} {seen['line']} {seen['printed']}"
                ends = self.once or state != "running"
                is_stale = is_stale or key != before
                is_due = is_stale and time.monotonic() - paged_s >= _PAGE_S
                if self.page is not None and (ends or is_due):
                    self._write(self.page, again=paged_s >= 0)
                    paged_s, is_stale = time.monotonic(), False
                if key != before:
                    desk.row(seen)
                    rows.add(seen, seen["text"])
                    before = key
                if ends:
                    break
                time.sleep(self.interval)
        return rows.result(NEGATIVE if state == "broken" else FINE)

    def _write(self, page: Path, *, again: bool) -> None:
        """Write the report; what this command has written itself may be replaced."""
        if again:
            with atomic.rules(atomic.WriteRules(force=True)):
                report.write(self.run_path, page)
        else:
            report.write(self.run_path, page)


def _seen(run: Path, story: Story) -> WatchedRun:
    return {
        "run": str(run), "state": story.state, "line": min(story.told.next_line, story.job.lines),
        "lines": story.job.lines, "printed": story.printed, "left_s": round(story.left_s, 1),
        "text": f"{run}: {story.verdict[1]}",
    }  # fmt: skip
