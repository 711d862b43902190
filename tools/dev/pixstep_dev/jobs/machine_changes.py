# SPDX-License-Identifier: MIT
"""A machine, what may change in it, and what each change has to mean for a job: a model of its own.

A change is a text of the machine file and another one in its place. What it means stands here as
the document says it (docs/JOBS.md), and is taken from nothing that decides it in the product.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

GREEN, GREY, AMBER, RED = "green", "grey", "amber", "red"
STATUS = {GREEN: 0, GREY: 0, AMBER: 1, RED: 2}
_ORDER = (GREEN, GREY, AMBER, RED)

MACHINE = """\
[clock]
pixel = "30 Hz"
divider = 1
sync = "lock"

[line]
lead_in = 2
pixels = 80

[boards.main]
kind = "mega"
port = "/dev/ttyACM0"
unit = 1

[motors.M39]
axis = 0
kind = "smooth"
steps_per_unit = "400 steps/mm"
direction = "+"
backlash = "250 steps"
profiles.line = "line.PRN"
profiles.move = "move.csv"
limits.max_speed = "1200 steps/px"

[motors.M40]
axis = 1
kind = "plain"
steps_per_unit = "12.5 steps/deg"
limits.max_speed = "200 steps/px"
limits.max_acceleration = "60 steps/px2"
limits.start_stop = "60 steps/px"
"""
NO_AXIS = "m1284 has 2 axes"


@dataclass(frozen=True)
class Expected:
    """What a row of the comparison has to say, of a key that nobody knows too."""

    field: str
    colour: str
    key: bool = False
    job: str = ""
    found: str = ""
    unknown: bool = False


@dataclass(frozen=True)
class MachineChange:
    """A change of the machine file, its rows, and the table that has another name after it."""

    name: str
    old: str
    new: str
    rows: tuple[Expected, ...]
    renames: tuple[str, str] = ("", "")  # what the job has under the first name is gone
    place: str = ""  # two changes of one place exclude each other


def _one(
    name: str, old: str, new: str, *rows: Expected, renames: tuple[str, str] = ("", ""),
    place: str = "",
) -> MachineChange:  # fmt: skip
    return MachineChange(name, old, new, rows, renames, place or rows[0].field)


def _row(
    field: str, colour: str, values: tuple[str, str] = ("", ""), *, key: bool = False,
    unknown: bool = False,
) -> Expected:  # fmt: skip
    return Expected(field, colour, key, *values, unknown=unknown)


KEY = True
_M40 = (
    "axis", "kind", "steps_per_unit", "limits.max_speed", "limits.max_acceleration",
    "limits.start_stop",
)  # fmt: skip
CHANGES = (
    _one("pixel clock", '"30 Hz"', '"31 Hz"',
         _row("clock.pixel", RED, ("30 Hz", "31 Hz"), key=KEY)),
    _one("pixel clock in other words", '"30 Hz"', '"0.03 kHz"', _row("file", GREY),
         place="clock.pixel"),
    _one("divider", "divider = 1", "divider = 2",
         _row("clock.divider", RED, ("1", "2"), key=KEY)),
    _one("divider left out", "divider = 1\n", "",
         _row("clock.divider", AMBER, key=KEY)),
    _one("sync", '"lock"', '"start"', _row("clock.sync", AMBER, ("lock", "start"))),
    _one("gate", "[clock]\n", "[clock]\ngate_edges = 90\n", _row("clock.gate_edges", AMBER)),
    _one("lead-in", "lead_in = 2", "lead_in = 5", _row("line.lead_in", AMBER, ("2", "5"))),
    _one("lead-out", "[line]\n", "[line]\nlead_out = 9\n", _row("line.lead_out", AMBER)),
    _one("scan offset back", "[line]\n", '[line]\nscan_offset_back = "2 steps"\n',
         _row("line.scan_offset_back", AMBER)),
    _one("pixels of other commands", "pixels = 80", "pixels = 90",
         _row("line.pixels", GREY, ("80", "90"))),
    _one("kind of board", '"mega"', '"m1284"',
         _row("boards.main.kind", RED, ("mega", "m1284"), key=KEY)),
    _one("port", "/dev/ttyACM0", "/dev/ttyACM1",
         _row("boards.main.port", GREY, ("/dev/ttyACM0", "/dev/ttyACM1"))),
    _one("address", "unit = 1", "unit = 7", _row("boards.main.unit", GREY, ("1", "7"))),
    _one("baud", "[boards.main]\n", "[boards.main]\nbaud = 19200\n",
         _row("boards.main.baud", GREY)),
    _one("axis", "axis = 0", "axis = 3", _row("motors.M39.axis", RED, ("0", "3"), key=KEY)),
    _one("smooth to plain", '"smooth"\n', '"plain"\n',
         _row("motors.M39.kind", RED, ("smooth", "plain"), key=KEY)),
    _one("scale", "400 steps/mm", "500 steps/mm",
         _row("motors.M39.steps_per_unit", RED, ("400 steps/mm", "500 steps/mm"), key=KEY)),
    _one("direction", 'direction = "+"', 'direction = "-"',
         _row("motors.M39.direction", RED, ("+", "-"), key=KEY)),
    _one("play, both above 0", '"250 steps"', '"100 steps"',
         _row("motors.M39.backlash", AMBER, ("250 steps", "100 steps"), key=KEY)),
    _one("play 0 today", '"250 steps"', '"0 steps"',
         _row("motors.M39.backlash", RED, ("250 steps", "0 steps"), key=KEY)),
    _one("more play than a pixel", '"250 steps"', '"1001 steps"',
         _row("motors.M39.backlash", RED, ("250 steps", "1001 steps"), key=KEY)),
    _one("limit that lines keep", "1200 steps/px", "1100 steps/px",
         _row("motors.M39.limits.max_speed", AMBER, ("1200 steps/px", "1100 steps/px"))),
    _one("limit that lines break", "1200 steps/px", "900 steps/px",
         _row("motors.M39.limits.max_speed", AMBER), _row("motors.M39 lines", RED)),
    _one("limit left out", 'limits.max_speed = "1200 steps/px"\n', "",
         _row("motors.M39.limits.max_speed", AMBER)),
    _one("line profile of other content", '"line.PRN"', '"other.PRN"',
         _row("motors.M39.profiles.line", GREY, ("line.PRN", "other.PRN")),
         _row("motors.M39.profiles.line sha256", RED, key=KEY)),
    _one("line profile of other name", '"line.PRN"', '"same.PRN"',
         _row("motors.M39.profiles.line", GREY, ("line.PRN", "same.PRN"))),
    _one("move profile", '"move.csv"', '"slow.csv"',
         _row("motors.M39.profiles.move", GREY),
         _row("motors.M39.profiles.move sha256", AMBER)),
    _one("home switch", "axis = 1", 'axis = 1\nhome_is_limit = "plus"',
         _row("motors.M40.home_is_limit", AMBER)),
    _one("word of programs", "axis = 1", 'axis = 1\nword = "A"', _row("motors.M40.word", GREY)),
    _one("motor gone", "[motors.M40]", "[motors.M42]", _row("motors.M40", RED), *(
         _row(f"motors.M42.{key}", GREY) for key in _M40), renames=("motors.M40.", "motors.M42.")),
    _one("unknown key of a motor", "steps_per_unit = \"12.5", 'colour = 3\nsteps_per_unit = "12.5',
         _row("motors.M40.colour", AMBER, ("-", "3"), unknown=True)),
    _one("unknown key of the clock", "[clock]\n", "[clock]\nphase = 4\n",
         _row("clock.phase", AMBER, ("-", "4"))),
    _one("unknown table", "[line]", "[laser]\npower = 1\n[line]", _row("laser", AMBER)),
    _one("a motor more", "[boards.main]", '[motors.M7]\naxis = 2\nkind = "plain"\n[boards.main]',
         _row("motors.M7.axis", GREY), _row("motors.M7.kind", GREY)),
    _one("a remark", "[clock]\n", "# a remark\n[clock]\n", _row("file", GREY)),
)  # fmt: skip


def text_of(changes: Iterable[MachineChange]) -> str:
    """Return the machine file with some changes."""
    text = MACHINE
    for one in changes:
        if text.count(one.old) != 1:
            raise ValueError(f"{one.name}: {one.old!r} stands there {text.count(one.old)} times")
        text = text.replace(one.old, one.new)
    return text


def exclude(first: MachineChange, second: MachineChange) -> bool:
    """Return whether two changes are of one place of the file."""
    return first.place == second.place


def lacks_axis(changes: Iterable[MachineChange]) -> bool:
    """Return whether a motor is on an axis that the board of the changed file does not have."""
    names = {one.name for one in changes}
    return "kind of board" in names and bool({"axis", "a motor more"} & names)


def expected(changes: Iterable[MachineChange]) -> dict[str, Expected]:
    """Return the rows that differ, by field; the file itself has one if nothing else differs."""
    several = [*changes]
    found = {row.field: row for one in several for row in one.rows}
    for before, after in (one.renames for one in several if one.renames[0]):
        for field in [name for name in found if name.startswith(before)]:
            row = found.pop(field)
            name = after + field.removeprefix(before)
            found[name] = row if row.unknown else Expected(name, GREY)
    if len(found) > 1:
        found.pop("file", None)
    return found


def verdict(rows: Iterable[Expected]) -> str:
    """Return the worst colour of some rows; grey is green."""
    worst = max((row.colour for row in rows), key=_ORDER.index, default=GREEN)
    return GREEN if worst == GREY else worst
