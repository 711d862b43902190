# SPDX-License-Identifier: MIT
"""What the log of a run says of each line of its job.

printed     every board has confirmed its end, or a person has said `--skip`
in flight   it may have begun: its blocks may be on a board. At most two are
left        nothing of it was sent
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from pixstep.jobs.run_log import Event

BEGIN, CHAIN, QUEUED, DONE = "begin", "chain", "queued", "done"
LOST, PAUSED, STOPPED, FINISHED = "lost", "paused", "stopped", "finished"
RESUME, REDO, SKIP, HOMED, MOVED = "resume", "redo", "skip", "homed", "moved"


@dataclass(frozen=True)
class Base:
    """An axis when a chain of lines began: its counters and its position."""

    unit: int
    axis: int
    lines_done: int
    next_block: int
    position_steps: int

    @classmethod
    def of(cls, data: dict[str, Any]) -> Base:
        """Return the axis of an event."""
        return cls(**{name: int(data[name]) for name in cls.__dataclass_fields__})


@dataclass
class History:
    """What a log tells. `chain` is the first line of the last chain, 0 before it begins.

    `bases` are the axes when it began, by motor.
    """

    lines: int
    printed: set[int] = field(default_factory=set)
    in_flight: list[int] = field(default_factory=list)
    chain: int = 0
    bases: dict[str, Base] = field(default_factory=dict)
    skipped: set[int] = field(default_factory=set)
    finished: bool = False
    last: Event = field(default_factory=dict)
    tags: dict[str, int] = field(default_factory=dict)  # of the boards, by name
    stored: dict[str, int] = field(default_factory=dict)  # what a board had in a tag's place

    @classmethod
    def of(cls, events: Iterable[Event]) -> History:
        """Return what events tell."""
        found = cls(0)
        for event in events:
            found.take(event)
        return found

    def take(self, event: Event) -> None:
        """Take an event."""
        kind, line = event.get("event"), int(event.get("line", 0))
        self.last = event
        if kind == BEGIN:
            self.lines = int(event["lines"])
            self.tags = {name: int(about["tag"]) for name, about in event["boards"].items()}
            self.stored = {
                name: int(about["bus_timeout_ms"]) for name, about in event["boards"].items()
            }
            axes = (about["axes"] for about in event["boards"].values())
            self.bases = {name: Base.of(data) for one in axes for name, data in one.items()}
        elif kind == CHAIN:
            self.chain, self.in_flight = line, []
            self.bases = {name: Base.of(data) for name, data in event["axes"].items()}
        elif kind == MOVED:
            self.chain = 0
            self.bases = {name: Base.of(data) for name, data in event["axes"].items()}
        elif kind == QUEUED:
            self.in_flight.append(line)
        elif kind in (DONE, SKIP):
            self._settle(line)
            self.printed.add(line)
            if kind == SKIP:
                self.skipped.add(line)
        elif kind == REDO:
            self._settle(line)
        elif kind == FINISHED:
            self.finished = True

    @property
    def next_line(self) -> int:
        """The first line that is neither printed nor skipped; the one after the last at the end."""
        return next((n for n in range(1, self.lines + 1) if n not in self.printed), self.lines + 1)

    def state(self, *, is_running: bool) -> str:
        """How the run is: finished, running, paused or broken."""
        if self.finished:
            return "finished"
        if is_running:
            return "running"
        return PAUSED if self.last.get("event") == PAUSED else "broken"

    def _settle(self, line: int) -> None:
        if line in self.in_flight:
            self.in_flight.remove(line)
