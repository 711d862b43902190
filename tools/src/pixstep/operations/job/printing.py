# SPDX-License-Identifier: MIT
"""Print a job: compared, armed once, its lines without a gap, every line logged.

What resuming a job has in common with that is here too: the comparison, the boards, signals, the
end.
"""

from __future__ import annotations

import contextlib
import getpass
import math
import signal
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NotRequired, TypedDict

from pixstep import signals
from pixstep.errors import FINE
from pixstep.operations import shared
from pixstep.operations.bus import StoppedError
from pixstep.operations.desk import Desk
from pixstep.operations.job import buses
from pixstep.operations.job.buses import BusOf, Compares
from pixstep.operations.job.reading import job_file, read
from pixstep.operations.kinds import PATH, TEXT
from pixstep.operations.request import flag, operation, option, shared_fields
from pixstep.operations.result import Result

if TYPE_CHECKING:
    from pixstep.jobs.comparison import ComparisonRow
    from pixstep.jobs.job import Job
    from pixstep.jobs.machine_copy import MachineCopy
    from pixstep.jobs.runner import RunWatch
    from pixstep.jobs.session import JobSession
    from pixstep.machine.files import MachineFile


Confirm = Callable[[str], bool]
_AMBER_SHOWN = 8


class LineOfRun(TypedDict):
    """A line that was in flight when a run was broken off: printed, left, broken or unknown."""

    line: int
    fate: str
    text: str


class RepeatedLine(TypedDict):
    """A line that was printed again, and what had become of it before: it may be exposed twice."""

    line: int
    was: str


class BoardOfRun(TypedDict):
    """A board as it is found: `trusted` if the positions of its motors hold."""

    board: str
    unit: int
    trusted: bool
    text: str


class RunOfJob(TypedDict):
    """A run of a job: finished, paused, running, broken or undecided.

    `printed` counts lines that every board has confirmed, `left_s` is what the others take. Of this
    run, `rests` counts how often motors rested between lines because this computer was late, and
    `reserve_px` is how many pixels before its turn a line was queued, at the least. `gap_px` is how
    many pixels of the clock passed between lines, rests included, all together (--time-gaps).
    """

    run: str
    job: str
    id: str
    state: str
    lines: int
    printed: int
    skipped: list[int]
    repeated: list[RepeatedLine]
    left_s: float
    rests: NotRequired[int]
    reserve_px: NotRequired[float | None]
    gap_px: NotRequired[int | None]
    boards: NotRequired[list[BoardOfRun]]
    in_flight: NotRequired[list[LineOfRun]]


@shared_fields
class Prints(Compares):
    """A request that prints lines of a job."""

    port: str | None = option(
        TEXT, "Port of the boards.", variable="PIXSTEP_PORT", default_text="of the machine file"
    )
    timeout: float | None = shared.timeout()
    accept_amber: bool = flag("Accept what is amber in the comparison.")
    records: bool = flag("Keep per-pixel records, a Parquet file a line in parts of the run.")
    time_gaps: bool = flag("Count the clock's pixels between lines, by a board's own counts.")

    def compare(self, desk: Desk, job: Job, found: MachineCopy, bus_of: BusOf) -> dict[str, Any]:
        """Compare a job with machine file and boards; return what goes into the log.

        The boards' clock is set in between, for which nothing may move. Raises RefusedError for
        red, and for amber to which nobody agrees.
        """
        from pixstep.jobs import comparison, judging, stations
        from pixstep.jobs.comparison import GREEN

        rows = self.compare_file(job, found)
        machine = found.tables
        desk.say(judging.apart(job, machine))
        stations.set_clock(stations.of_job(job, machine, bus_of), machine)
        rows += buses.compared(job, machine, bus_of)
        accepted = self._accepted(desk, rows)
        comparison.require(job, rows, accept_amber=accepted)
        shown = [one.told() for one in rows if one.key or one.colour is not GREEN]
        told: dict[str, Any] = {
            "comparison": comparison.verdict(rows).word,
            "fields": shown,
            "equal": len(rows) - len(shown),
        }
        if told["comparison"] == "amber":
            told["accepted_by"] = _user()
        return told

    @staticmethod
    def compare_file(job: Job, found: MachineCopy) -> list[ComparisonRow]:
        """Compare a job with the machine file alone. Raises RefusedError for red."""
        from pixstep.jobs import comparison

        rows = comparison.with_machine(job, found)
        comparison.require(job, rows, accept_amber=True)
        return rows

    def _accepted(self, desk: Desk, rows: list[ComparisonRow]) -> bool:
        from pixstep.jobs import comparison
        from pixstep.jobs.comparison import AMBER

        confirm: Confirm | None = desk.view
        if self.accept_amber or confirm is None or comparison.verdict(rows) is not AMBER:
            return self.accept_amber
        amber = [one for one in rows if one.colour is AMBER]
        for one in amber[:_AMBER_SHOWN]:
            desk.tell(f"amber: {one.place}: {one.field}: the job has {one.job}, found {one.found}: "
                      f"{one.why}")  # fmt: skip
        return confirm(f"{len(amber)} differences are amber. Print?")


def safe(job: Job, machine: MachineFile) -> bool:
    """Return whether no line needs the host while it moves."""
    from pixstep.jobs import judging

    return all(judging.room(job, machine, name).safe for name in job.motors)


@contextlib.contextmanager
def watched(desk: Desk, pause_asked: Callable[[], bool]) -> Iterator[RunWatch]:
    """Yield what a run is watched by.

    While lines move, Ctrl-C asks for a pause and the second one stops; before that it stops.
    """
    from pixstep.jobs.runner import RunWatch

    asked = threading.Event()

    def take(_number: int, _frame: object) -> None:
        if asked.is_set() or not watch.in_lines:
            raise KeyboardInterrupt
        asked.set()

    with desk.progress("printing") as show, _on_ctrl_c(take):
        watch = RunWatch(lambda: asked.is_set() or pause_asked(), show, desk.aside)
        yield watch


@contextlib.contextmanager
def _on_ctrl_c(take: Callable[[int, Any], None]) -> Iterator[None]:
    """Do something at Ctrl-C, where this is the thread that gets it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, take)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def make(session: JobSession, path: Path, *, may_move: bool) -> Result:
    """Make the lines that are left, and return the result.

    Raises StoppedError after a signal, JobBrokenError after a fault, both saying where all is.
    """
    from pixstep.jobs.runner import JobBrokenError

    try:
        ended = session.make(may_move=may_move)
    except KeyboardInterrupt as error:
        told = "; ".join(getattr(error, "__notes__", ())) or "nothing moved"
        raise StoppedError(
            f"stopped by {signals.name(error)}: {told} (`pixstep job resume {path}`)",
            signals.status(error),
        ) from None
    except JobBrokenError as error:
        raise JobBrokenError(
            f"{error}; `pixstep job resume {path}` goes on: type it before you home", error.rows
        ) from None
    data = facts_of(path, session.job, session.told, ended.value)
    reserve = None if math.isinf(session.reserve_px) else round(session.reserve_px, 1)
    if reserve is not None and not session.rests:
        # No line came too late: what is below 0 is this computer's clock against the board's.
        reserve = max(0.0, reserve)
    data["rests"], data["reserve_px"] = session.rests, reserve
    if session.gaps:
        data["gap_px"] = session.gaps.px if session.gaps.looks else None
    return Result(data, "\n".join([text_of(data), *_gaps(data)]), FINE)


def _gaps(data: RunOfJob) -> Iterator[str]:
    """Yield whether there were gaps between lines, and how near one was."""
    if data["rests"]:
        yield f"{data['rests']} rests between lines, because this computer was late"
    elif data["reserve_px"] is not None:
        yield (
            f"no gap between lines: each was queued at least {data['reserve_px']:g} pixels before "
            f"its turn"
        )
    if data.get("gap_px") is not None:
        yield f"{data['gap_px']} pixels of the clock passed between lines"


def facts_of(path: Path, job: Job, told: Any, state: str) -> RunOfJob:
    """Return the facts of a run."""
    left = job.lines - len(told.printed)
    return {
        "run": str(path),
        "job": str(job.path),
        "id": job.header.id,
        "state": state,
        "lines": job.lines,
        "printed": len(told.printed) - len(told.skipped),
        "skipped": sorted(told.skipped),
        "repeated": [{"line": line, "was": was} for line, was in told.twice.items()],
        "left_s": round(float(left * job.pixels / job.pixel_hz), 3),
    }


def text_of(data: RunOfJob) -> str:
    """Return the state of a run in a sentence or two."""
    skipped = data["skipped"]
    more = f", skipped {', '.join(map(str, skipped))}" if skipped else ""
    repeated = ", ".join(f"{one['line']} ({one['was']})" for one in data["repeated"])
    more += f", repeated {repeated}" if repeated else ""
    text = f"{data['run']}: {data['state']}: {data['printed']} of {data['lines']} lines{more}"
    if data["state"] == "finished":
        return text
    text += f", {data['left_s']:.1f} s left"
    if data["state"] in ("paused", "broken", "undecided"):
        text += f": `pixstep job resume {data['run']}` goes on"
    return text


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):  # a system without a name for this user
        return "unknown"


@operation("job run")
class JobRun(Prints):
    """Print a job on the boards of the machine file.

    The job is compared first: red is refused, amber wants a yes or --accept-amber. The first line
    begins on the pixel clock, of several boards on the same edge; each board chains the others
    without a gap, and one line is queued ahead. The folder NAME.pxrun has the log: a line counts as
    printed when every board says so by counter and position. Ctrl-C pauses at the end of the line
    after the one that moves, a second one stops at once. `pixstep job resume` goes on.
    """

    result = RunOfJob
    needs_machine = True

    job: Path = job_file()
    folder: Path | None = option(
        PATH, "Folder of the run.", shown="NAME.pxrun", default_text="the job's name"
    )
    to_start: bool = flag("Bring motors that are elsewhere to where line 1 begins.")

    def run(self, desk: Desk) -> Result:
        """Compare the job, begin a run, print."""
        job, found = read(self.job), buses.today(desk.facts)
        from pixstep.jobs import positioning
        from pixstep.jobs.run_folder import SUFFIX, Parts, RunFolder
        from pixstep.jobs.run_log import History
        from pixstep.jobs.session import JobSession, elsewhere
        from pixstep.jobs.stations import of_job

        path = self.folder or Path(self.job.name).with_suffix(SUFFIX)
        RunFolder.refuse_other(path, job)
        machine = found.tables
        with buses.opened(desk, machine, self.port, self.timeout) as bus_of:
            told = self.compare(desk, job, found, bus_of)
            stations = of_job(job, machine, bus_of)
            away = positioning.off(job, 1, stations)
            if away and not self.to_start:
                raise elsewhere(away)
            folder = RunFolder.begin(path, job)
            with folder.log() as log, watched(desk, lambda: folder.pause_asked) as watch:
                parts = Parts(path) if self.records else None
                session = JobSession(job, machine, stations, log, History(0), watch, parts)
                if self.time_gaps:
                    session.time_gaps()
                session.begin(told, safe=safe(job, machine))
                try:
                    return make(session, path, may_move=self.to_start)
                finally:
                    folder.forget_pause()
