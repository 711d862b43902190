# SPDX-License-Identifier: MIT
"""What a run's log tells a reader: its verdict in a sentence, its lines, what happened when."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import UTC, datetime

from pixstep.jobs import run_log
from pixstep.jobs.job import Job
from pixstep.jobs.run_folder import RunFolder
from pixstep.jobs.run_log import Event, History

GREEN, BLUE, AMBER, RED = "green", "blue", "amber", "red"
LEFT, PRINTED, SKIPPED, IN_FLIGHT, REPEATED = range(5)  # what became of a line
_QUIET = (run_log.QUEUED, run_log.DONE)


@dataclass
class Story:
    """A run as its log tells it. `fates` are those of all lines, in their order."""

    job: Job
    told: History
    state: str
    events: list[Event] = field(repr=False)
    now_s: float = 0.0

    @classmethod
    def of(cls, folder: RunFolder, job: Job) -> Story:
        """Read the log of a run."""
        is_running = folder.is_running  # asked first: what has ended since is in the log then
        events = folder.events()
        told = folder.told(events)
        return cls(job, told, told.state(is_running=is_running), events, time.time())

    @property
    def printed(self) -> int:
        """How many lines every board has confirmed."""
        return len(self.told.printed) - len(self.told.skipped)

    @property
    def fates(self) -> list[int]:
        """What became of each line."""
        found = [LEFT] * self.job.lines
        for line in self.told.in_flight:
            found[line - 1] = IN_FLIGHT
        for line in self.told.printed:
            found[line - 1] = SKIPPED if line in self.told.skipped else PRINTED
        for line in self.told.twice:
            found[line - 1] = REPEATED
        return found

    @property
    def line_s(self) -> float:
        """How long a line takes."""
        return float(self.job.pixels / self.job.pixel_hz)

    @property
    def left_s(self) -> float:
        """How long the lines take that are left, of the one that moves what is left of it."""
        left = (self.job.lines - len(self.told.printed)) * self.line_s
        if self.state != "running" or not self.told.in_flight:
            return left
        begun = next((one for one in reversed(self.events) if one["event"] in _BEGUN), None)
        passed = self.now_s - float(begun["at"]) if begun else 0.0
        return left - min(max(passed, 0.0), self.line_s)

    @property
    def verdict(self) -> tuple[str, str]:
        """The colour of the run, and its verdict in a sentence."""
        lines, job_lines = f"{self.printed} of {self.job.lines} lines", self.job.lines
        if self.state == "running":
            now = min(self.told.next_line, job_lines)
            left = duration_text(self.left_s)
            return BLUE, f"Running: line {now} of {job_lines}, {left} left"
        if self.state == "paused":
            left = duration_text(self.left_s)
            return (
                AMBER,
                f"Paused after line {self.told.next_line - 1}: {lines} printed, {left} left",
            )
        if self.state == "broken":
            return RED, f"Broken off: {lines} printed{self._why()}"
        if self.told.skipped:
            skipped = ", ".join(map(str, sorted(self.told.skipped)))
            return AMBER, f"Finished, not whole: {lines} printed; skipped: {skipped}{self._twice}"
        return AMBER if self._twice else GREEN, f"Finished: {lines} printed{self._twice}"

    @property
    def _twice(self) -> str:
        """The lines that were begun and printed again, in words."""
        told = ", ".join(f"{line} ({was})" for line, was in self.told.twice.items())
        return f"; repeated: {told}" if told else ""

    @property
    def comparison(self) -> Event:
        """The newest comparison of the job with the machine: `comparison`, `fields`, `equal`."""
        compared = (one for one in reversed(self.events) if "comparison" in one)
        return next(compared, {})

    @property
    def chains(self) -> int:
        """How often lines began from rest; between lines of a chain there is no gap."""
        return sum(one["event"] == run_log.CHAIN for one in self.events)

    @property
    def seconds(self) -> float:
        """From the first event to the last one, by the clock of the day."""
        return float(self.events[-1]["at"] - self.events[0]["at"]) if self.events else 0.0

    def happened(self) -> Iterator[tuple[str, str, str]]:
        """Yield time, name and words of each event but those of single lines."""
        for one in self.events:
            if one["event"] not in _QUIET:
                at = datetime.fromtimestamp(one["at"], UTC)
                yield f"{at:%Y-%m-%d %H:%M:%S}", one["event"], _words(one)

    def _why(self) -> str:
        """Return what ended the lines that began last, as far as the log says it."""
        for one in reversed(self.events):
            if one["event"] in (run_log.LOST, run_log.STOPPED):
                return f"; {one['why']}"
            if one["event"] in (run_log.CHAIN, run_log.RESUME):
                break
        return "; the log says no reason, as when a computer dies"


_BEGUN = (run_log.CHAIN, run_log.DONE)


def _words(event: Event) -> str:
    """Return what an event tells, for a reader."""
    kind = event["event"]
    if kind == run_log.BEGIN:
        boards = ", ".join(
            f"{name} ({one['kind']} {one['firmware']}, address {one['unit']})"
            for name, one in event["boards"].items()
        )
        return f"{event['lines']} lines of {event['pixels']} pixels; boards: {boards}"
    if kind == run_log.CHAIN:
        return f"lines begin at line {event['line']}"
    if kind == run_log.MOVED:
        ways = (f"{name} from {a} to {b}" for name, (a, b) in event["motors"].items())
        return ", ".join(ways)
    if kind == run_log.HOMED:
        return ", ".join(event["motors"])
    if kind == run_log.LOST:
        return f"board {event['board']}: {event['why']}; the others end after line {event['last']}"
    if kind == run_log.STOPPED:
        return f"in line {event['line']}: {event['why']}"
    if kind in (run_log.REDO, run_log.SKIP):
        was = f": it was {event['was']}" if "was" in event else ""
        return f"line {event['line']}{was}"
    if kind == run_log.FOUND:
        return "; ".join(f"line {one['line']}: {one['text']}" for one in event["lines"])
    if kind == run_log.RESUME:
        return f"the machine compared: {event.get('comparison', '')}"
    return f"after line {event['line']}" if "line" in event else ""


def duration_text(seconds: float) -> str:
    """Return a time as people say it."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min {rest} s"
