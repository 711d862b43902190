# SPDX-License-Identifier: MIT
"""What the boards hold beside what a job was made for: kind, axes, clock, settings, image."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pixstep.board import boards, capability, settings, values
from pixstep.board import registers as regs
from pixstep.board.device import Device, Identity
from pixstep.jobs import comparison, judging
from pixstep.jobs.comparison import ComparisonRow, Rule, row, row_of_lines
from pixstep.jobs.job import Job
from pixstep.lines.units import hz_words
from pixstep.machine.files import MachineFile

_CLOCK = ("pixel_hz_num", "pixel_hz_den", "divider", "sync", "gate_edges")
_SPEAKING = ("unit_address", "baud_100", "parity")
_POLICY = "backlash_policy"
_BACKLASH = "backlash"


def absent(name: str, why: str) -> ComparisonRow:
    """Return the row of a board that does not answer."""
    return row(_place(name), "board", comparison.BOARD_ABSENT, "there", why, equal=False)


def with_board(
    job: Job, machine: MachineFile, name: str, board: Device, who: Identity
) -> list[ComparisonRow]:
    """Compare a job with what the board holds that the machine file calls by a name."""
    return [*_OnBoard(job, machine, name, board, who, settings.read(board)).rows()]


@dataclass(frozen=True)
class _OnBoard:
    """A board's settings beside a job."""

    job: Job
    machine: MachineFile
    name: str
    board: Device
    who: Identity
    there: dict[str, int]

    def rows(self) -> Iterator[ComparisonRow]:
        """Yield what matters to the job's lines, then the other settings."""
        kind = self.machine.boards[self.name].kind
        yield self._row("kind", comparison.BOARD_KIND, kind, self.who.board)
        yield from self._axes()
        yield from self._clock()
        yield from self._settings()
        yield from self._lines()

    def _motors(self) -> list[str]:
        there = self.machine.motors
        return [
            name for name in self.job.motors
            if name in there and self.machine.board_name(there[name]) == self.name
        ]  # fmt: skip

    def _axes(self) -> Iterator[ComparisonRow]:
        for name in self._motors():
            axis = self.machine[name].axis
            has = axis < self.who.axis_count
            found = axis if has else f"axes 0 to {self.who.axis_count - 1}"
            yield self._row(f"axis of {name}", comparison.BOARD_AXIS, axis, found)

    @property
    def _clock_out_hz(self) -> int | None:
        """The clock that the machine file lets this board make."""
        return self.machine.boards[self.name].clock_out_hz

    def _clock(self) -> Iterator[ComparisonRow]:
        """Yield the clock that the job was made for beside the registers."""
        clock = self.job.machine.tables.clock
        found = hz_words(values.hz_of(self.there))
        yield self._row("pixel_hz", comparison.BOARD_CLOCK, hz_words(clock.pixel), found)
        divider = settings.divider_of(self.there)
        yield self._row("divider", comparison.BOARD_CLOCK, clock.edges, divider)
        gate = clock.gate_edges or (0 if self.board.has(boards.GATE_FEATURE) else None)
        wanted_here = settings.of_clock(clock.sync, None, gate, self._clock_out_hz)
        for key, wanted in wanted_here.items():
            texts = (self._words(key, value) for value in (wanted, self.there[key]))
            yield self._row(key, comparison.BOARD_FOLLOWS, *texts)

    def _settings(self) -> Iterator[ComparisonRow]:
        """Yield the other settings: beside the job's, or beside those of a new board."""
        copy = self._copy()
        wanted = copy[values.TABLE] if copy else settings.defaults()
        own = self._clock_out_hz
        if copy and "firmware" in copy:
            yield self._row("firmware", comparison.FIRMWARE, copy["firmware"], self.who.firmware)
        for name, held in self.there.items():
            if name in _CLOCK or name not in wanted or (name == boards.CLOCK_OUT_SETTING and own):
                continue
            rule = self._rule(name, copied=copy is not None)
            if held != wanted[name] or copy:
                texts = (self._words(name, value) for value in (wanted[name], held))
                yield self._row(name, rule, *texts)

    def _copy(self) -> dict[str, Any] | None:
        """Return the settings that went into the job with this board."""
        member = self.job.header.settings.get(self.name)
        return tomllib.loads(self.job.copies[member].decode()) if member else None

    def _rule(self, name: str, *, copied: bool) -> Rule:
        if name in _SPEAKING:
            return comparison.BOARD_PORT
        if copied:
            return comparison.BOARD_SETTING
        return comparison.BOARD_POLICY if name == _POLICY else comparison.BOARD_OWN

    def _lines(self) -> Iterator[ComparisonRow]:
        """Yield whether the board takes each motor's lines, by its own limits."""
        if self.who.board != self.machine.boards[self.name].kind:
            return  # its limits say nothing then
        motors = self._motors()
        if any(self.job.header.motors[name].backlash for name in motors):
            has = self.board.has(_BACKLASH)
            yield self._row(
                "backlash", comparison.BOARD_FEATURE, "needed", "needed" if has else "no"
            )
        clock = settings.of_clock(self.machine.clock.sync, self.machine.clock.edges)
        hz = self.machine.pixel_hz
        limits = capability.connected_limits(self.board, hz, len(motors), clock)
        for name in motors:
            judged = judging.of_motor(self.job, self.machine, name, limits)
            yield row_of_lines(_place(self.name), f"lines of {name}", self.job, judged)

    def _words(self, name: str, value: int) -> str:
        """Return a setting in words if it has some, else as a number."""
        register = next(item for item in regs.settings() if item.name == name)
        return regs.words(register, value) or f"{value}{values.unit_text(register)}"

    def _row(self, field: str, rule: Rule, job: object, found: object) -> ComparisonRow:
        return row(_place(self.name), field, rule, job, found, equal=str(job) == str(found))


def _place(name: str) -> str:
    return f"board {name}"
