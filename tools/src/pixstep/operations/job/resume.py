# SPDX-License-Identifier: MIT
"""Go on with a run that was paused or broken off; say how a run is; ask it to pause."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep.errors import FINE, NEGATIVE, REFUSED, AskedText, RefusedError, UserError
from pixstep.operations.asked import AskedError
from pixstep.operations.desk import Desk
from pixstep.operations.job import buses, printing
from pixstep.operations.job.printing import Prints, RunOfJob
from pixstep.operations.job.reading import opened, run_folder
from pixstep.operations.kinds import Whole
from pixstep.operations.request import Request, flag, operation, option
from pixstep.operations.result import Page, Result

if TYPE_CHECKING:
    from pixstep.jobs.job import Job
    from pixstep.jobs.resuming import ResumeVerdict
    from pixstep.jobs.run_log import History
    from pixstep.jobs.session import JobSession
    from pixstep.machine.files import MachineFile

_SPARE_S = 5.0


@operation("job resume")
class JobResume(Prints):
    """Go on with a run that was paused or broken off.

    The boards are asked what they have made since. Each line is printed, not printed, broken at a
    pixel, or unknown, where a board was reset or is gone. Of broken and unknown lines, at most two,
    nothing is guessed: they are listed, nothing moves, exit status 3, until --redo or --skip says
    what is to become of each. After a hard stop, a reset or a power cut positions do not hold: the
    motors are homed first. A pressed emergency stop, a latched fault and a missing pixel
    clock are named too, and stop it. What boards say is kept in the log; a resume that is refused
    has decided nothing.
    """

    result = RunOfJob
    needs_machine = True

    run_path: Path = run_folder()
    redo: tuple[int, ...] = option(
        Whole(1), "Print line N again; again for more.", many=True, shown="N", default_text="none"
    )
    skip: tuple[int, ...] = option(
        Whole(1), "Leave line N as it is; again for more.", many=True, shown="N",
        default_text="none",
    )  # fmt: skip
    home: bool = flag("Home the motors whose positions do not hold, by the machine file.")
    homed: bool = flag("The motors whose positions did not hold have been homed since.")
    together: bool = flag("Go on although boards have made different lines.")

    def run(self, desk: Desk) -> Result:
        """Look at the boards, and print what is left."""
        folder, job = opened(self.run_path)
        from pixstep.jobs import resuming, run_log
        from pixstep.jobs.run_folder import Parts
        from pixstep.jobs.runner import RunWatch
        from pixstep.jobs.session import JobSession
        from pixstep.jobs.stations import of_job

        found = buses.today(desk.facts)
        machine = found.tables
        with folder.log() as log:
            told = folder.history()
            if told.finished:
                data = printing.facts_of(self.run_path, job, told, "finished")
                return Result(data, printing.text_of(data))
            if (told.chain or told.printed) and not job.header.resumable:
                raise RefusedError(f"{self.run_path}: the job is not resumable: begin it again")
            self.compare_file(job, found)  # red needs no board, and nobody homes for it in vain
            with buses.opened(desk, machine, self.port, self.timeout) as bus_of:
                stations = of_job(job, machine, bus_of)
                most_s = 2 * job.pixels / float(job.pixel_hz) + _SPARE_S
                resuming.await_rest(stations, most_s)
                verdict = resuming.judge(job, told, stations)
                resuming.discard_left(stations)
                parts = Parts(self.run_path) if self.records else None
                session = JobSession(job, machine, stations, log, told, RunWatch(), parts)
                known = resuming.known_of(verdict)
                if any(one["line"] not in told.found for one in known):
                    session.note({"event": run_log.FOUND, "lines": known})
                troubles = [*resuming.troubles(machine, stations)]
                refused = self._undecided(job, told, verdict, troubles)
                if refused:
                    return refused
                for name in verdict.to_home if self.home else ():
                    _home_direction(machine, name)
                with printing.watched(desk, lambda: folder.pause_asked) as watch:
                    session.watch = watch
                    if self.time_gaps:
                        session.time_gaps()
                    for station in stations:
                        resuming.clear(station)
                    facts = self.compare(desk, job, found, bus_of)
                    self._settle(session, verdict)  # a resume that is refused has decided nothing
                    session.note({"event": run_log.RESUME, **facts})
                    if not told.lines:
                        session.begin(facts, safe=printing.safe(job, machine))
                    self._home(desk, session, verdict)
                    try:
                        return printing.make(session, self.run_path, may_move=True)
                    finally:
                        folder.forget_pause()

    def _undecided(
        self, job: Job, told: Any, verdict: ResumeVerdict, troubles: Iterable[str]
    ) -> Result | None:
        """Return what somebody has to decide or mend first; None if there is nothing."""
        asked = {one.number for one in verdict.asked}
        for number in (*self.redo, *self.skip):
            if number in self.redo and number in told.skipped:
                raise UserError(f"line {number}: it was skipped at an earlier resume: that stays")
            if number not in asked | told.skipped | _to_repeat(told):
                raise UserError(
                    f"line {number} is neither broken nor unknown"
                    + (f": {', '.join(map(str, sorted(asked)))} are" if asked else "")
                )
        both = set(self.redo) & set(self.skip)
        if both:
            raise AskedError("line {line}: either {redo} or {skip}", line=min(both))
        texts: list[str] = [
            AskedText("line {n} is {text}: {redo} {n} or {skip} {n}", n=one.number, text=one.text)
            for one in verdict.asked
            if one.number not in (*self.redo, *self.skip)
        ]
        if verdict.disagree and not self.together:
            texts.append(AskedText(
                "the boards have made different lines: {together} goes on with the first that is "
                "not printed on all of them"
            ))  # fmt: skip
        to_home = verdict.to_home
        if to_home and not (self.homed or self.home):
            texts.append(AskedText(
                "positions do not hold: {motors}: home them, then {homed}; or {home}",
                motors=", ".join(to_home),
            ))  # fmt: skip
        texts += troubles
        if not texts:
            return None
        data = printing.facts_of(self.run_path, job, told, "undecided")
        _add_boards(data, verdict)
        rows = [f"board {one['board']}: {one['text']}" for one in data["boards"]]
        rows += [f"line {one.number}: {one.text}" for one in verdict.lines
                 if one.number not in asked]  # fmt: skip

        def write(page: Page) -> None:
            for text in (*rows, *texts, "nothing has moved"):
                page.tell(text)

        return Result(data, write, REFUSED)

    def _settle(self, session: JobSession, verdict: ResumeVerdict) -> None:
        """Log what became of the lines in flight."""
        from pixstep.jobs import run_log
        from pixstep.jobs.resuming import Fate

        for one in verdict.lines:
            if one.fate is Fate.PRINTED:
                session.note({"event": run_log.DONE, "line": one.number})
            elif one.number in self.skip:
                session.note({"event": run_log.SKIP, "line": one.number, "was": one.text})
            else:
                session.note({"event": run_log.REDO, "line": one.number, "was": one.text})
        for number in sorted({*self.skip} & _to_repeat(session.told)):
            was = ", ".join(session.told.repeated[number])
            session.note({"event": run_log.SKIP, "line": number, "was": was})

    def _home(self, desk: Desk, session: JobSession, verdict: ResumeVerdict) -> None:
        """Home motors whose positions do not hold, and bring them to their line from its side."""
        from pixstep.jobs import positioning, run_log

        away = [one for one in verdict.boards if not one.trusted]
        if not away or session.told.next_line > session.job.lines:
            return
        if self.home:
            for name in verdict.to_home:
                _home_motor(desk, session.machine, name, session.stations, self.port)
        session.note({"event": run_log.HOMED, "motors": verdict.to_home})
        moved = positioning.every(
            session.job, session.told.next_line, [one.station for one in away]
        )
        session.bring(moved)


def _to_repeat(told: History) -> set[int]:
    """Return the lines that are to be printed again, by an earlier resume, and are not yet."""
    return {*told.repeated} - told.printed


def _home_motor(
    desk: Desk, machine: MachineFile, name: str, stations: Iterable[Any], port: str | None
) -> None:
    """Home a motor as `pixstep board home` does by the machine file."""
    from pixstep.operations import python
    from pixstep.operations.board.motion import BoardHome

    station = next(one for one in stations if name in one.motors)
    given: dict[str, Any] = {
        "unit": station.board.unit,
        "direction": _home_direction(machine, name),
    }
    place = port or machine.boards[station.name].port
    if desk.link is None and place is not None:
        given["port"] = place
    done = python.run(BoardHome, given, machine=machine.path, motor=name, link=station.link)
    desk.aside(done.page())


def _home_direction(machine: MachineFile, name: str) -> str:
    """Return where a motor's home switch is. Raises UserError if the machine file does not say."""
    motor = machine[name]
    if machine.profile(motor, "home") is None or motor.home_is_limit not in ("plus", "minus"):
        raise AskedError(
            "{path}: motor {name} has no profiles.home, or no home_is_limit that says in which "
            "direction its home switch is: home it, then {homed}", path=machine.path, name=name,
        )  # fmt: skip
    return motor.home_is_limit


def _add_boards(data: RunOfJob, verdict: ResumeVerdict) -> None:
    data["boards"] = [
        {
            "board": one.station.name, "unit": one.station.board.unit, "trusted": one.trusted,
            "text": one.text,
        }
        for one in verdict.boards
    ]  # fmt: skip
    data["in_flight"] = [
        {"line": one.number, "fate": one.fate.value, "text": one.text} for one in verdict.lines
    ]


@operation("job status")
class JobStatus(Request):
    """Say how far a run has come, by its log alone; no board is asked.

    Exit status 0; 1 if the run was broken off.
    """

    result = RunOfJob

    run_path: Path = run_folder()

    def run(self, desk: Desk) -> Result:
        """Read the log."""
        folder, job = opened(self.run_path)
        running = folder.is_running  # first: a run that ends meanwhile has its end in the log
        told = folder.history()
        state = told.state(is_running=running)
        data = printing.facts_of(self.run_path, job, told, state)
        data["in_flight"] = [
            {"line": number, "fate": "in flight", "text": _known_text(told, number)}
            for number in told.in_flight
        ]
        texts = [printing.text_of(data)]
        if told.in_flight and state != "running":
            texts.append(f"in flight: line {', '.join(map(str, told.in_flight))}")
            texts += (f"line {one}: {told.found[one][1]}" for one in told.in_flight
                      if one in told.found)  # fmt: skip
        if told.last.get("event") == "stopped":
            texts.append(f"stopped: {told.last['why']}")
        return Result(data, "\n".join(texts), NEGATIVE if state == "broken" else FINE)


def _known_text(told: Any, number: int) -> str:
    """Return what boards have said of a line in flight at a resume, if they have."""
    return str(told.found[number][1]) if number in told.found else "queued, not confirmed"


@operation("job pause")
class JobPause(Request):
    """Ask a run in another console to pause.

    It pauses at the end of the line after the one that moves, as Ctrl-C there does.
    """

    result = RunOfJob

    run_path: Path = run_folder()

    def run(self, desk: Desk) -> Result:
        """Leave the request in the run's folder."""
        folder, job = opened(self.run_path)
        if not folder.is_running:
            raise RefusedError(f"{self.run_path}: nobody runs it now (`pixstep job status`)")
        folder.ask_pause()
        told = folder.history()
        data = printing.facts_of(self.run_path, job, told, "running")
        where = "the line after the one that moves"  # where that is not known yet
        if len(told.in_flight) > 1 or job.lines in told.in_flight:
            where = f"line {max(told.in_flight)}"
        return Result(data, f"{self.run_path}: pauses at the end of {where}")
