# SPDX-License-Identifier: MIT
"""A run from where its log says to its end: each stretch of lines that are left, in position."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from pixstep.board import run
from pixstep.board.errors import BoardError
from pixstep.board.link import World
from pixstep.errors import AskedText, RefusedError
from pixstep.jobs import positioning, run_log, stations
from pixstep.jobs.gaps import Gaps
from pixstep.jobs.job import Job
from pixstep.jobs.positioning import Off
from pixstep.jobs.run_folder import Parts
from pixstep.jobs.run_log import Event, History, RunLog
from pixstep.jobs.runner import Chain, ChainEnd, RunWatch
from pixstep.jobs.stations import Station
from pixstep.machine.files import MachineFile


@dataclass
class JobSession:
    """A job on its boards, with the log that says how far it is.

    `rests` counts how often the motors rested because this computer was late; `reserve_px` is how
    many pixels before its turn a line was in the queues, at the least.
    """

    job: Job
    machine: MachineFile
    stations: list[Station]
    log: RunLog
    told: History
    watch: RunWatch
    parts: Parts | None = None
    gaps: Gaps | None = None
    clock: Callable[[], float] = time.time
    rests: int = 0
    reserve_px: float = math.inf
    _brought: bool = False

    @property
    def world(self) -> World:
        """The time of the boards."""
        return self.stations[0].link.world

    def note(self, event: Event) -> None:
        """Log an event with the time of day and the boards' time; it is on the disk then."""
        seconds = {"at": round(self.clock(), 3), "s": round(self.world.now_s(), 3)}
        self.log.add({**event, **seconds})
        self.told.take(event)

    def time_gaps(self) -> None:
        """Count the clock's pixels between lines."""
        clock = self.machine.clock
        self.gaps = Gaps(self.job, clock.edges, gated=bool(clock.gate_edges))

    def begin(self, facts: Event, *, safe: bool) -> None:
        """Log who prints what, on which boards, and give each board its tag."""
        two_lines_s = 2 * self.job.pixels / float(self.machine.pixel_hz)
        boards = {}
        for station in self.stations:
            stored, who = station.board.setting(stations.SILENCE), station.board.who()
            station.rebase()
            boards[station.name] = {
                "unit": who.unit, "kind": who.board, "firmware": who.firmware,
                stations.TAG: stations.new_tag(), stations.SILENCE: stored,
                "silence_ms": stations.silence_ms(stored, two_lines_s, safe=safe),
                "axes": {name: vars(base) for name, base in station.bases.items()},
            }  # fmt: skip
        self.note({
            "event": run_log.BEGIN, "job": self.job.header.id, "lines": self.job.lines,
            "pixels": self.job.pixels, "boards": boards, **facts,
        })  # fmt: skip

    def make(self, *, may_move: bool) -> ChainEnd:
        """Make the lines that are left; raises JobBrokenError saying where everything is.

        Motors that are not where their line begins are brought there, if they `may_move`, else they
        are refused.
        """
        while (first := self.told.next_line) <= self.job.lines:
            if self.watch.pause_asked():
                self.note({"event": run_log.PAUSED, "line": first - 1})
                return ChainEnd.PAUSED
            for station in self.stations:
                stations.hold(station.board, stations.TAG, self.told.tags[station.name])
                stations.hold(station.board, stations.SILENCE, self.told.silence_ms[station.name])
            stations.ready(self.stations)
            away = self._away(first, takes_play=may_move and self._is_first)
            if away and not may_move:
                raise elsewhere(away)
            if away:
                self.bring(away)
            last = self._end_of_stretch(first)
            chain = Chain(
                self.job, self.machine, self.stations, self.world, self.note, self.watch, first,
                last, self.parts, self.gaps,
            )  # fmt: skip
            ended = chain.make()
            self.reserve_px = min(self.reserve_px, chain.reserve_px)
            if ended is ChainEnd.PAUSED:
                self.note({"event": run_log.PAUSED, "line": chain.made})
                return ended
            if ended is ChainEnd.DRY:
                self._run_dry(chain)
        self.note({"event": run_log.FINISHED, "line": self.job.lines})
        self._give_boards_back()
        return ChainEnd.FINISHED

    def _away(self, line: int, *, takes_play: bool) -> list[Off]:
        """Return the motors that are not where a line begins.

        With `takes_play` also those that may have come there from the wrong side of their play.
        """
        motors = self.job.header.motors
        return [
            one for one in positioning.every(self.job, line, self.stations)
            if one.is_away or (takes_play and motors[one.motor].backlash and one.side)
        ]  # fmt: skip

    @property
    def _is_first(self) -> bool:
        """True as long as nobody knows from which side motors came: before lines and moves."""
        return not (self.told.chain or self._brought)

    def bring(self, away: list[Off]) -> None:
        """Bring motors to where the next line begins."""
        self._brought = True
        for text in positioning.go(self.machine, self.job, away, self.world):
            self.watch.say(text)
        for station in self.stations:
            station.rebase()
        self.note({
            "event": run_log.MOVED,
            "motors": {one.motor: [one.position_steps, one.wanted_steps] for one in away},
            "axes": stations.bases_of(self.stations),
        })  # fmt: skip

    def _end_of_stretch(self, first: int) -> int:
        """Return the last line before one that is printed already."""
        printed = (n for n in range(first, self.job.lines + 1) if n in self.told.printed)
        return next(printed, self.job.lines + 1) - 1

    def _run_dry(self, chain: Chain) -> None:
        """Forget what came too late, so that the lines begin again at the next one."""
        self.rests += 1
        late = f" ({', '.join(chain.late)} had no other line)" if chain.late else ""
        self.watch.say(f"this computer was late: the motors rested after line {chain.made}{late}")
        for station in self.stations:
            run.discard(station.lines)

    def _give_boards_back(self) -> None:
        """Put the boards' own times for a silent bus back; they are in no run any more."""
        for station in self.stations:
            try:
                stations.hold(station.board, stations.SILENCE, self.told.stored[station.name])
                stations.hold(station.board, stations.TAG, stations.NO_TAG)
            except BoardError as error:
                self.watch.say(str(error))


def elsewhere(away: Iterable[Off]) -> RefusedError:
    """Return the refusal of motors that are not where their line begins."""
    return RefusedError(AskedText(
        "{away} ({to_start} brings motors to where the line begins)",
        away="; ".join(map(str, away)),
    ))  # fmt: skip
