# SPDX-License-Identifier: MIT
"""A run of a job as it goes on, and a page that shows it with the boards.

The report of a run: one HTML file that tells how it went, and draws every line of it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, NotRequired, TypedDict

from pixstep import atomic, signals
from pixstep.board.port import BAUD, LEAST_BAUD, MOST_BAUD, PARITIES, Port
from pixstep.errors import FINE, NEGATIVE
from pixstep.lazy import lazy
from pixstep.operations import serve, shared
from pixstep.operations.asked import AskedError
from pixstep.operations.bus import UNITS, Units
from pixstep.operations.desk import Desk
from pixstep.operations.facts import Facts
from pixstep.operations.job.reading import opened, run_folder
from pixstep.operations.kinds import FILE, OUTPUT, PATH, TEXT, Choice, Time, Whole
from pixstep.operations.request import Request, argument, flag, operation, option
from pixstep.operations.result import Data, Result

if TYPE_CHECKING:
    from pixstep.jobs.report.pixels import ReportFigures
    from pixstep.jobs.report.story import Story
    from pixstep.operations.live import serving as live
    from pixstep.operations.live.job_run import LiveRun
else:
    live = lazy("pixstep.operations.live.serving")


class ReportedJob(TypedDict):
    """The report of a run: its verdict with a colour, green, blue, amber or red.

    `records` counts pixels of which the run has records, `measured` those that were measured.
    `worst_off_steps` is how far a motor was from where it should have been, `worst_error_ticks` how
    far an edge was off, at the most; `strange` counts records that expect another position than the
    job does.
    """

    run: str
    output: str
    bytes: int
    colour: str
    verdict: str
    records: int
    measured: int
    worst_off_steps: int
    worst_error_ticks: int
    strange: int


@operation("job report")
class JobReport(Request):
    """Write the report of a run: one HTML file, which needs no network.

    It begins with the verdict. Then come the comparison of the job with the machine, a map of the
    job line by pixel, and drawings of any line: speed, position, edge error; expected, actual and
    measured position. The page of a run that goes on loads itself again and again, and `pixstep
    watch --page` keeps its file new. Exit status 0; 1 if the report is amber or red.
    """

    result = ReportedJob

    run_path: Path = run_folder()
    output: Path | None = option(
        OUTPUT, "HTML file to write.", "-o", shown="FILE", default_text="NAME.html"
    )
    measured: Path | None = option(
        FILE, "What an encoder measured: a table (.csv, .parquet) of line, motor, pixel and "
        "measured_steps, positions as the boards count them.", shown="FILE",
    )  # fmt: skip

    def run(self, desk: Desk) -> Result:
        """Read the run and write its report."""
        output = self.output or Path(f"{self.run_path.resolve().stem}.html")
        data = write(self.run_path, output, self.measured)
        status = NEGATIVE if data["colour"] in ("amber", "red") else FINE
        return Result(data, f"{output}: {data['verdict']}", status)


def write(run: Path, output: Path, measured: Path | None = None) -> ReportedJob:
    """Write the report of a run into a file."""
    folder, job = opened(run)
    folder.require_outside(output)
    from pixstep.jobs.report import page, pixels
    from pixstep.jobs.report.story import Story

    story = Story.of(folder, job)
    figures = pixels.of_run(job, run, measured)
    text = page.text(story, figures, run.resolve().name)
    atomic.write_text(output, text)
    return _facts(run, output, len(text.encode()), story, figures)


def _facts(run: Path, output: Path, size: int, story: Story, figures: ReportFigures) -> ReportedJob:
    from pixstep.jobs.report import page

    return {
        "run": str(run), "output": str(output), "bytes": size,
        "colour": page.colour(story, figures), "verdict": story.verdict[1],
        "records": figures.records, "measured": figures.measured,
        "worst_off_steps": abs(figures.worst_off), "worst_error_ticks": figures.worst_error,
        "strange": figures.strange,
    }  # fmt: skip


_PAGE_S = 2.0  # the file of a report is not written more often
_ROW_S, _WEB_S = 0.5, 0.25


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
    """A run at each change that was seen; `web` is the address of the page for browsers."""

    looks: list[WatchedRun]
    web: NotRequired[str]


@operation("watch")
class WatchRun(Request):
    """Watch a run of a job: the line that moves, and the time that is left.

    It reads the run's log; no board is asked, so it may run beside `job run`. It ends with the run,
    or by Ctrl-C. Exit status 0; 1 if the run was broken off.

    --web serves a page for browsers instead, until Ctrl-C: axes, speeds, positions, clock, faults,
    and each line as it runs. It shows the boards of --port, without it those of the machine file.
    With a run it shows the run's boards too, if a server has their ports (`pixstep serve`). The
    page only reads, unless --allow-stop gives it a button. docs/LIVE.md has the rest.
    """

    result = WatchedRuns
    json_rows = "change"
    needs_machine = True

    run_path: Path | None = argument(PATH, shown="NAME.pxrun", required=False)
    interval: float | None = option(
        Time("s", 0.05, 3600), "Time from one look to the next.",
        default_text=f"{_ROW_S}s, with --web {_WEB_S}s",
    )  # fmt: skip
    once: bool = flag("Look once.")
    page: Path | None = option(
        OUTPUT, "HTML file: the report of the run, written again as the run goes on.", shown="FILE"
    )
    web: bool = flag("Serve a live page for browsers.")
    at: serve.Door = option(
        serve.DOOR, "Address of the page; on the loopback alone unless a host is named.",
        default=(serve.LOOPBACK[0], 7421), default_text="127.0.0.1:7421",
    )  # fmt: skip
    allow_stop: bool = flag("Give the page a button that stops all boards.")
    token_file: Path | None = option(
        PATH, "File of the page's token; made if it is missing.", shown="PATH",
        default_text="a new token each time",
    )  # fmt: skip
    port: str | None = option(
        TEXT, "Port of the boards.", variable="PIXSTEP_PORT",
        default_text="of the run, or of the machine file",
    )  # fmt: skip
    units: Units = option(
        UNITS, "Addresses on --port: 1 or 1,2,5-8, or all.", "--unit", default=(1,),
        default_text="1",
    )  # fmt: skip
    baud: int = option(
        Whole(LEAST_BAUD, MOST_BAUD), "Rate of the serial line of --port.", default=BAUD
    )
    parity: str | None = option(
        Choice(list(PARITIES), any_case=True), "Parity of --port.",
        default_text="E; N on a pseudo terminal, which has no parity",
    )  # fmt: skip
    timeout: float | None = shared.timeout()

    @classmethod
    def prepare(cls, facts: Facts, say: Callable[[Iterable[str]], None]) -> None:
        """Let no mistake in the machine file keep anybody from watching."""
        facts.on_mistake = lambda error: say((f"{error}: not used",))

    @property
    def bus(self) -> Port:
        """The port that is named, and how it is spoken to."""
        return Port(self.port or "", self.baud, self.parity, self.timeout)

    @property
    def interval_s(self) -> float:
        """The time from one look to the next."""
        return self.interval or (_WEB_S if self.web else _ROW_S)

    def run(self, desk: Desk) -> Result:
        """Look until the run has ended, or Ctrl-C comes."""
        self._refuse()
        if self.run_path is None:
            with live.served(desk, self, None) as address, signals.until_ctrl_c():
                while True:
                    time.sleep(_PAGE_S)
            return Result({"looks": [], "web": address}, told=True)
        folder, job = opened(self.run_path)
        from pixstep.jobs.report.story import Story

        def read() -> Story:
            return Story.of(folder, job)

        if not self.web:
            return self._follow(desk, self.run_path, read, None, {})
        from pixstep.operations.live.job_run import LiveRun

        shown = LiveRun(str(self.run_path), job, read())
        with live.served(desk, self, shown) as address:
            return self._follow(desk, self.run_path, read, shown, {"web": address})

    def _follow(
        self, desk: Desk, run: Path, read: Callable[[], Story], shown: LiveRun | None, beside: Data
    ) -> Result:
        """Look at a run until it has ended; with a page that shows it, until Ctrl-C."""
        rows = desk.rows("looks", beside)
        state, before, paged_s, is_stale = "running", "", -_PAGE_S, True
        with signals.until_ctrl_c(), desk.progress(str(run)) as show:
            while True:
                story = read()
                state = story.state
                if shown:
                    shown.story = story
                show(len(story.told.printed) / story.job.lines)
                seen = _seen(run, story)
                key = f"{state} {seen['line']} {seen['printed']}"
                ends = self.once or state != "running"
                is_stale = is_stale or key != before
                is_due = is_stale and time.monotonic() - paged_s >= _PAGE_S
                if self.page is not None and is_stale and (ends or is_due):
                    self._write(run, self.page, again=paged_s >= 0)
                    paged_s, is_stale = time.monotonic(), False
                if key != before:
                    desk.row(seen)
                    rows.add(seen, seen["text"])
                    before = key
                if ends and not shown:
                    break
                time.sleep(self.interval_s)
        return rows.result(NEGATIVE if state == "broken" else FINE)

    def _write(self, run: Path, page: Path, *, again: bool) -> None:
        """Write the report; what this command has written itself may be replaced."""
        if again:
            with atomic.rules(atomic.WriteRules(force=True)):
                write(run, page)
        else:
            write(run, page)

    def _refuse(self) -> None:
        """Refuse what does not go together."""
        if not self.web:
            if self.run_path is None:
                raise AskedError("{run_path} is missing, or {web}")
            if self.allow_stop or self.token_file:
                raise AskedError("{allow_stop} and {token_file} are for the page: add {web}")
        elif self.once:
            raise AskedError("{web} and {once}: a page is looked at until Ctrl-C")
        elif self.page and not self.run_path:
            raise AskedError("{page}: the report of a run: name the run")


def _seen(run: Path, story: Story) -> WatchedRun:
    return {
        "run": str(run), "state": story.state, "line": min(story.told.next_line, story.job.lines),
        "lines": story.job.lines, "printed": story.printed, "left_s": round(story.left_s, 1),
        "text": f"{run}: {story.verdict[1]}",
    }  # fmt: skip
