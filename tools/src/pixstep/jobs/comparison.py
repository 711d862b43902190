# SPDX-License-Identifier: MIT
"""A job's configuration beside today's: a row a field, with what its difference means.

How much a difference between a job's configuration and today's means: the rule of each field.

A key field decided the counts of the lines when the job was made: the machine cannot make a
difference good while it prints.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from enum import IntEnum
from fractions import Fraction
from pathlib import Path

from pixstep.errors import RefusedError
from pixstep.formats.files import examine_bytes
from pixstep.formats.findings import LENIENT
from pixstep.formats.motion import MotionFile
from pixstep.jobs import judging
from pixstep.jobs.job import MACHINE, Job
from pixstep.jobs.judging import MotorFindings
from pixstep.jobs.machine_copy import NOTHING, MachineCopy
from pixstep.lines.line import SMOOTH
from pixstep.machine.model import LimitsTable
from pixstep.profiles import origin

Keys = tuple[str, ...]
ANY = "*"


class Colour(IntEnum):
    """What a difference means, the worst last."""

    GREEN = 0
    """Equal."""
    GREY = 1
    """It differs, and makes no difference."""
    AMBER = 2
    """It differs: a person has to agree before anything moves."""
    RED = 3
    """It differs: the job must not be printed."""

    @property
    def word(self) -> str:
        """Its name."""
        return self.name.lower()


GREEN, GREY, AMBER, RED = Colour.GREEN, Colour.GREY, Colour.AMBER, Colour.RED


@dataclass(frozen=True)
class Rule:
    """What a difference of a field means, and why."""

    colour: Colour
    why: str
    key: bool = False


_NAMES_ONLY = Rule(GREY, "where the board is found")
_DEFAULT = Rule(GREY, "a default of other commands")
_LIMIT = Rule(AMBER, "the lines still keep it, or their own row says not")
_PLACE = Rule(AMBER, "the job's lines have their own")

RULES: dict[Keys, Rule] = {
    ("clock", "pixel"): Rule(RED, "the counts are per pixel of the job's clock", key=True),
    ("clock", "divider"): Rule(RED, "the counts are per pixel of so many edges", key=True),
    ("clock", "sync"): Rule(AMBER, "lines follow the clock in another way"),
    ("clock", "gate_edges"): Rule(AMBER, "line zero is at another edge of a burst"),
    ("line", "motor"): _DEFAULT,
    ("line", "pixels"): _DEFAULT,
    ("line", "lead_in"): _PLACE,
    ("line", "lead_out"): _PLACE,
    ("line", "scan_offset_forward"): _PLACE,
    ("line", "scan_offset_back"): _PLACE,
    ("program", ANY): _DEFAULT,
    ("epics", ANY): _DEFAULT,
    ("boards", ANY, "kind"): Rule(RED, "another kind of board", key=True),
    ("boards", ANY, "port"): _NAMES_ONLY,
    ("boards", ANY, "unit"): _NAMES_ONLY,
    ("boards", ANY, "baud"): _NAMES_ONLY,
    ("boards", ANY, "parity"): _NAMES_ONLY,
    ("boards", ANY, "clock_out_hz"): Rule(AMBER, "the pixel clock comes from another source"),
    ("motors", ANY, "board"): Rule(RED, "the motor is on another board", key=True),
    ("motors", ANY, "axis"): Rule(RED, "the motor is on another axis", key=True),
    ("motors", ANY, "kind"): Rule(RED, "the counts are decoded in another way", key=True),
    ("motors", ANY, "steps_per_unit"): Rule(RED, "the counts are of another length", key=True),
    ("motors", ANY, "direction"): Rule(RED, "the load would run the other way", key=True),
    ("motors", ANY, "backlash"): Rule(AMBER, "no line of this motor takes it up"),
    ("motors", ANY, "word"): _DEFAULT,
    ("motors", ANY, "home_is_limit"): Rule(AMBER, "homing stops at another switch"),
    ("motors", ANY, "limits", ANY): _LIMIT,
    ("motors", ANY, "epics", ANY): _DEFAULT,
    ("motors", ANY, "epics", ANY, ANY): _DEFAULT,
    ("motors", ANY, "profiles", ANY): Rule(GREY, "the name of a file; its content has its own row"),
}
HAPS = Rule(AMBER, "homing is faster or slower")
NOT_USED = Rule(GREY, "not in the job")
UNKNOWN = Rule(AMBER, "this pixstep does not know the key")
GONE = Rule(RED, "the machine does not have it any more")
LINES = Rule(RED, "a line is refused by what the machine can do today")
LAYOUT = Rule(GREY, "comments or layout")

# What a board holds; a run writes its clock, so that a difference can be made good.
BOARD_KIND = Rule(RED, "another board answers there", key=True)
BOARD_AXIS = Rule(RED, "the board does not have the axis", key=True)
BOARD_ABSENT = Rule(RED, "it does not answer")
BOARD_FEATURE = Rule(RED, "its image cannot take up play")
BOARD_CLOCK = Rule(AMBER, "the board is set otherwise until a run sets it", key=True)
BOARD_FOLLOWS = Rule(AMBER, "the board is set otherwise until a run sets it")
BOARD_POLICY = Rule(AMBER, "play would be taken up at reversals only")
BOARD_SETTING = Rule(AMBER, "the board is set otherwise than when the job was made")
BOARD_OWN = Rule(GREY, "not as delivered; the job does not say what it should be")
BOARD_PORT = Rule(GREY, "how the board is spoken to")
FIRMWARE = Rule(AMBER, "another image than when the job was made")


def of(keys: Keys) -> Rule:
    """Return the rule of a field of a machine file."""
    for pattern, rule in RULES.items():
        if len(pattern) == len(keys) and all(
            one in (ANY, key) for one, key in zip(pattern, keys, strict=True)
        ):
            return rule
    return UNKNOWN


def profile(use: str, *, used: bool, from_files: bool) -> Rule:
    """Return the rule of what a profile holds: one that the lines were made by decided them."""
    if used:
        return Rule(RED, "the lines were made by another profile", key=True)
    if use != "line":
        return Rule(AMBER, "moves before and after the lines differ")
    if from_files:
        return Rule(AMBER, "the lines came from files that may have been made by it")
    return Rule(GREY, "no line was made by it")


def backlash(job: int, today: int, speed: int) -> Rule:
    """Return the rule of the play that a motor's lines take up, all in steps and steps/pixel."""
    if max(job, today) > speed:
        return Rule(RED, f"it does not fit a pixel at {speed} steps/px", key=True)
    if not job:
        return Rule(RED, "the lines have no room to take play up", key=True)
    if not today:
        return Rule(RED, "the lines take up play that the motor does not have", key=True)
    return Rule(AMBER, f"the job's {job} steps are sent", key=True)


_MOTOR_KEYS = ("board", "axis", "kind", "steps_per_unit", "direction")
_MORE_KEYS = ("word", "home_is_limit")
_TABLES = {
    "clock": ("pixel", "divider", "sync", "gate_edges"),
    "line": ("motor", "pixels", "lead_in", "lead_out", "scan_offset_forward", "scan_offset_back"),
    "program": ("feed_time", "top_feed", "other_feed", "segment_time"),
}
_BOARD = ("kind", "port", "unit", "baud", "parity", "clock_out_hz")
_USES = ("line", "move", "home")


@dataclass(frozen=True)
class ComparisonRow:
    """A field of a configuration: what the job says, what is found, and what that means.

    `place` is the file or the board where it was found.
    """

    place: str
    field: str
    key: bool
    colour: Colour
    job: str
    found: str
    why: str = ""

    def told(self) -> dict[str, str | bool]:
        """Return the row as plain data."""
        return {**vars(self), "colour": self.colour.word}


def row(
    place: str, field: str, rule: Rule, job: object, found: object, *, equal: bool
) -> ComparisonRow:
    """Return the row of a field: green if it is equal, else as its rule says."""
    colour, why = (GREEN, "") if equal else (rule.colour, rule.why)
    return ComparisonRow(place, field, rule.key, colour, _told(job), _told(found), why)


def row_of_lines(place: str, field: str, job: Job, judged: MotorFindings) -> ComparisonRow:
    """Return the row of a motor's lines: whether they pass the limits of today."""
    found = judged.refusal or f"all {job.lines} pass"
    equal = not judged.refusal
    return row(place, field, LINES, f"{job.lines} lines", found, equal=equal)


def verdict(rows: Iterable[ComparisonRow]) -> Colour:
    """Return the worst of some rows; grey ones count as green."""
    worst = max((one.colour for one in rows), default=GREEN)
    return GREEN if worst is GREY else worst


def require(job: Job, rows: Iterable[ComparisonRow], *, accept_amber: bool) -> None:
    """Refuse what is to move by a job whose configuration is not today's.

    Raises RefusedError for red, and for amber that nobody has accepted.
    """
    found = [*rows]
    worst = verdict(found)
    if worst is RED or (worst is AMBER and not accept_amber):
        first = next(one for one in found if one.colour is worst)
        raise RefusedError(
            f"{job.path}: {worst.word}: {first.place}: {first.field}: the job has {first.job}, "
            f"found {first.found}: {first.why} (`pixstep job check` shows all)"
        )


def with_machine(job: Job, today: MachineCopy) -> list[ComparisonRow]:
    """Compare a job with a machine file of today."""
    return [*_Comparison(job, today).rows()]


@dataclass(frozen=True)
class _Comparison:
    """A job's copy of a machine file beside today's."""

    job: Job
    today: MachineCopy

    def rows(self) -> Iterator[ComparisonRow]:
        """Yield a row a field, in the order of a machine file."""
        found = [*self._fields(), *self._unknown()]
        found += self._rest({one.field for one in found})
        yield from found
        same = all(one.colour is GREEN for one in found)
        if same and self.today.data != self.job.copies[MACHINE]:
            yield self._row("file", LAYOUT, "as copied", "changed", equal=False)

    def _fields(self) -> Iterator[ComparisonRow]:
        for table, keys in _TABLES.items():
            for key in keys:
                yield self._compared((table, key))
        for name in self._boards():
            yield from self._board(name)
        for name in self.job.motors:
            yield from self._motor(name)

    def _boards(self) -> list[str]:
        """Return the job's boards by name."""
        then = self.job.machine.tables
        return list(dict.fromkeys(then.board_name(then[name]) for name in self.job.motors))

    def _board(self, name: str) -> Iterator[ComparisonRow]:
        if name not in self.today.tables.boards:
            yield self._row(f"boards.{name}", GONE, "there", "gone", equal=False)
            return
        for key in _BOARD:
            yield self._compared(("boards", name, key))
        judged = judging.of_board(self.job, self.today.tables, name)
        yield row_of_lines(self._place, f"boards.{name} time", self.job, judged)

    def _motor(self, name: str) -> Iterator[ComparisonRow]:
        if name not in self.today.tables.motors:
            yield self._row(f"motors.{name}", GONE, "there", "gone", equal=False)
            return
        for key in _MOTOR_KEYS:
            yield self._compared(("motors", name, key))
        yield self._backlash(name)
        yield from self._file(name)
        for key in _MORE_KEYS:
            yield self._compared(("motors", name, key))
        for key in LimitsTable.model_fields:
            yield self._compared(("motors", name, "limits", key))
        for use in _USES:
            yield self._compared(("motors", name, "profiles", use))
            yield from self._profile(name, use)
        judged = judging.of_motor(self.job, self.today.tables, name)
        yield row_of_lines(self._place, f"motors.{name} lines", self.job, judged)

    def _compared(self, keys: Keys) -> ComparisonRow:
        """Return the row of a key of the file: by what it means, however it is written."""
        then, now = self.job.machine, self.today
        rule = of(keys)
        equal = then.value(keys) == now.value(keys)
        found = self._row(".".join(keys), rule, then.text(keys), now.text(keys), equal=equal)
        missing = (keys in then.values) != (keys in now.values)
        if missing and equal and rule.colour is not GREY:
            where = "today" if keys in then.values else "in the job"
            return replace(found, colour=AMBER, why=f"missing {where}; its default is the same")
        return found

    def _backlash(self, name: str) -> ComparisonRow:
        """Return the row of the play that the job's lines have in them."""
        about, keys = self.job.header.motors[name], ("motors", name, "backlash")
        if about.decode != SMOOTH or about.role not in ("scan", "lines"):
            return self._compared(keys)
        today = self.today.tables[name].backlash_steps
        rule = backlash(about.backlash, today, self._speed(name))
        equal = about.backlash == today and (not today or rule.colour is not RED)
        texts = (f"{steps} steps" for steps in (about.backlash, today))
        found = self._row(".".join(keys), rule, *texts, equal=equal)
        missing = (keys in self.job.machine.values) != (keys in self.today.values)
        if equal and missing:
            why = "missing on one side; its default is the same"
            return replace(found, colour=AMBER, why=why)
        return found

    def _file(self, name: str) -> Iterator[ComparisonRow]:
        """Yield what the file of a motor's lines was made for, as far as it says it."""
        about, today = self.job.header.motors[name], self.today.tables
        place = f"motors.{name} file"
        if about.file_hz:
            other = origin.OtherFrequency(about.file, Fraction(about.file_hz), today.pixel_hz)
            same = origin.is_same(other.made_for, other.used)
            found = (f"{float(hz):.10g} Hz" for hz in (other.made_for, other.used))
            rule = Rule(RED if other.too_fast else AMBER, f"{about.file}: {other.text}", key=True)
            yield self._row(f"{place} pixel", rule, *found, equal=same)
        if about.file_motor:
            rule = Rule(AMBER, f"{about.file} was made for another motor", key=True)
            same = about.file_motor == name
            yield self._row(f"{place} motor", rule, about.file_motor, name, equal=same)

    def _speed(self, name: str) -> int:
        """Return the speed of a motor's lines, the lowest if they differ."""
        if speed := self.job.header.motors[name].speed:
            return speed
        keys = self.job.shapes_of(name)
        speeds = (self.job.shapes[key].line().line_speed for key, _ in keys)
        return min(filter(None, speeds), default=0)

    def _profile(self, name: str, use: str) -> Iterator[ComparisonRow]:
        """Yield the sum of a profile, and of one for homing how much of it homing may use."""
        about = self.job.header.motors[name]
        member = about.profiles.get(use)
        then = self.job.copies[member] if member else None
        now, trouble = self._today(name, use)
        if then is None and now is None and not trouble:
            return
        field = f"motors.{name}.profiles.{use} sha256"
        rule = profile(use, used=use == about.used, from_files=about.role == "lines")
        yield self._row(field, rule, _sum(then), trouble or _sum(now), equal=then == now)
        if use == "home":
            haps = (_haps(then), _haps(now))
            field = f"motors.{name}.profiles.home HAPs"
            yield self._row(field, HAPS, *haps, equal=haps[0] == haps[1])

    def _today(self, name: str, use: str) -> tuple[bytes | None, str]:
        """Return today's profile, and why it cannot be read if it cannot."""
        machine = self.today.tables
        path = machine.profile(machine[name], use)
        if path is None:
            return None, ""
        try:
            return path.read_bytes(), ""
        except OSError as error:
            return None, f"{path.name}: {error.strerror or error}"

    def _unknown(self) -> Iterator[ComparisonRow]:
        then, now = self.job.machine, self.today
        for keys in sorted({*then.unknown, *now.unknown}):
            there = [copy.under(keys) for copy in (then, now)]
            equal = there[0] == there[1]
            yield self._row(".".join(keys), UNKNOWN, *there, equal=equal)

    def _rest(self, covered: set[str]) -> Iterator[ComparisonRow]:
        """Yield what differs in the files and has no row yet: what lines do not depend on."""
        then, now = self.job.machine, self.today
        for keys in dict.fromkeys([*then.values, *now.values]):
            pair = [copy.values.get(keys, NOTHING) for copy in (then, now)]
            above = {".".join(keys[:count]) for count in range(1, len(keys) + 1)}
            if pair[0] != pair[1] and not above & covered:
                rule = of(keys) if self._is_used(keys) else NOT_USED
                yield self._row(".".join(keys), rule, *pair, equal=False)

    def _is_used(self, keys: Keys) -> bool:
        """True for keys that are of no motor or board, or of one that the job has."""
        used = {"motors": self.job.motors, "boards": self._boards()}.get(keys[0])
        return used is None or len(keys) < 2 or keys[1] in used

    @property
    def _place(self) -> str:
        return self.today.tables.path.name

    def _row(
        self, field: str, rule: Rule, job: object, found: object, *, equal: bool
    ) -> ComparisonRow:
        return row(self._place, field, rule, job, found, equal=equal)


def _sum(data: bytes | None) -> str:
    return NOTHING if data is None else hashlib.sha256(data).hexdigest()[:16]


def _haps(data: bytes | None) -> str:
    """Return the HAPs of a profile's header; nothing of one without a header."""
    file = examine_bytes(Path("profile"), data, LENIENT, raw=True).file if data else None
    header = file.header if isinstance(file, MotionFile) else None
    return str(header.haps) if header else NOTHING


def _told(value: object) -> str:
    return str(value) or NOTHING
