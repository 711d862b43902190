# SPDX-License-Identifier: MIT
"""Machine files: read, with line, key and value of every mistake; changed; begun."""

import difflib
import json
import math
import re
import tomllib
from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import Path

from pydantic import BaseModel, ValidationError

from pixstep import atomic, formats, tomltext
from pixstep.board import boards
from pixstep.errors import AskedText, RefusedError, UserError, one_line
from pixstep.machine import describe, model
from pixstep.machine.model import MachineTables, MotorTable, contradictions
from pixstep.profiles import origin

_MOST_SHOWN = 40  # characters of a value in a message
_UNKNOWN = "unknown key"
_REASONS = {"missing": "is missing", "extra_forbidden": _UNKNOWN, "too_short": "is empty"}


class MachineFile(MachineTables):
    """A machine that a file describes: MachineFile.load("machine.toml")["M39"]."""

    @classmethod
    def load(cls, path: str | Path) -> "MachineFile":
        """Read a file. Raises UserError naming file, line, key and value of the first mistake."""
        machine, found = _read(Path(path))
        if machine is None or found:
            raise RefusedError(found[0])
        return machine

    def lead_in_of(self, motor: MotorTable | None) -> int:
        """Return the constant pixels before an image of a motor's lines.

        They are those of the header of its move profile if that has some, else `line.lead_in`.
        """
        path = self.profile(motor, "move") if motor else None
        header = formats.read_motion(path).header if path and path.is_file() else None
        return (header.lead_in_px if header else 0) or self.line.lead_in


def parse(text: str) -> MachineFile:
    """Return the machine of a text that is valid."""
    return MachineFile.model_validate(_with_names(tomllib.loads(text)))


def of_content(content: dict[str, object], path: Path) -> MachineFile:
    """Return the machine of what a file says. Raises pydantic's ValidationError for a mistake."""
    machine = MachineFile.model_validate(_with_names(content))
    machine._path = path
    return machine


def problems(path: Path) -> list[str]:
    """Return every mistake of a file, a line of text each, in the order of the file.

    Raises UserError for a file that is no TOML at all.
    """
    return _read(path)[1]


def _read(path: Path) -> tuple[MachineFile | None, list[str]]:
    """Return the machine, None if a value is wrong, and the mistakes."""
    text, content = tomltext.read(path)
    found: list[tuple[Sequence[str | int], str, object]]
    machine = None
    try:
        machine = of_content(content, path)
        found = [(keys, reason, _value(content, keys)) for keys, reason in contradictions(machine)]
    except ValidationError as error:
        found = [
            (item["loc"], reason(item["type"], item["msg"]), _value(content, item["loc"]))
            for item in error.errors(include_url=False, include_context=False)
        ]
    return machine, told(text, path, found)


def told(
    text: str, path: Path, found: Iterable[tuple[Sequence[str | int], str, object]]
) -> list[str]:
    """Return mistakes of a file's text as lines: each has keys, a reason, a value."""
    placed = sorted(_placed(text, *item) for item in found)
    return [f"{path}:{line}: {message}" for line, message in placed]


def _with_names(content: dict[str, object]) -> dict[str, object]:
    """Return the content with the name of each motor inside of its table, where it has none."""
    motors = content.get("motors")
    if not isinstance(motors, dict):
        return content
    named = {
        name: {"name": name} | table if isinstance(table, dict) else table
        for name, table in motors.items()
    }
    return content | {"motors": named}


def reason(kind: str, message: str) -> str:
    """Return in our words what pydantic says."""
    return _REASONS.get(kind) or message.removeprefix("Value error, ").replace(
        "Input should be", "expected"
    )


def _value(content: object, keys: Sequence[str | int]) -> object:
    """Return what the file has at some keys; None if it has nothing there."""
    for key in keys:
        if not isinstance(content, dict) or key not in content:
            return None
        content = content[key]
    return content


def _placed(text: str, keys: Sequence[str | int], reason: str, value: object) -> tuple[int, str]:
    """Return the line of some keys, or of the nearest table around them, and the message."""
    depth = len(keys)
    line = None
    while depth and line is None:
        line = tomltext.line_of(text, keys[:depth])
        depth -= 1
    if reason == _UNKNOWN and (close := _alike(keys)):
        reason = f"{_UNKNOWN}: is {close} meant?"
    name = ".".join(one_line(str(key), _MOST_SHOWN) for key in keys)
    shown = "" if value is None or isinstance(value, dict) else f" = {_shown(value)}"
    return line or 1, f"{name}{shown}: {one_line(reason.removeprefix(f'{value!r}: '))}"


def _alike(keys: Sequence[str | int]) -> str:
    """Return the key that a mistyped one may have meant; "" if none looks like it."""
    tables = [one for one in vars(model).values() if isinstance(one, type(BaseModel))]
    known = {name for table in tables for name in table.model_fields}
    return next(iter(difflib.get_close_matches(str(keys[-1]), sorted(known), 1)), "")


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _MOST_SHOWN else f"{text[:_MOST_SHOWN]}..."


def set_backlash(path: Path, motor: str, steps: int) -> None:
    """Write the play of a motor, in steps, into a machine file.

    Raises UserError naming the mistake for a file that is wrong before.
    """
    MachineFile.load(path)[motor]  # names the mistake of a wrong file, and a missing motor
    text, _ = tomltext.read(path)
    import tomlkit  # takes long to load

    document = tomlkit.parse(text)
    try:
        document["motors"][motor]["backlash"] = f"{steps} steps"
    except (KeyError, TypeError):
        raise UserError(f"{path}: motors.{motor} is not a table of its own") from None
    with atomic.rules(atomic.WriteRules(force=True)):
        atomic.write_text(path, document.as_string())


_HEAD = """\
# A machine: its pixel clock, its boards and its motors, for the commands of pixstep.
# docs/MACHINE.md explains every key. `pixstep machine check` checks this file.
#
# Figures have units: "100.13 Hz", "3 um", "12 mm/s", "200 mm/s2", "4 px", "250 steps",
# "128 steps/px2". A bare number is Hz, steps, steps/px, steps/px2 or pixels.

[clock]
pixel = "{hz} Hz" # of its edges, exact: "30000/1001 Hz" is understood
{divider} # edges of the clock in a pixel, 1 to 1000: gentler accelerations at kilohertz
{sync} # free of the clock, start on an edge of it, or lock to it until the line's end
# gate_edges = 20 # of a clock that rests between lines: from a burst's first edge to line zero

[line]
{motor_key}pixels = 60 # length of a line, both ramps included
# lead_in = 4 # pixels at constant speed before the image
# lead_out = 4 # and after it, of a job
# scan_offset_back = "0 um" # a job moves the image of lines back; scan_offset_forward: forth

[boards.main]
kind = "{board}"
# port = "/dev/ttyACM0"
# unit = 1 # Modbus address
# baud = 115200
# parity = "E" # E, O or N
# clock_out_hz = {out_hz} # the board makes the pixel clock itself, on its pin CLOCK_OUT
"""

_MOTOR = """
[motors.{key}]
axis = {axis}
kind = "{kind}" # smooth: accelerates inside of a pixel; plain: one speed in each pixel
steps_per_unit = "400 steps/mm" # or "2.5 um/step", "12.5 steps/deg"
direction = "+" # "-": the load's positive direction is the motor's negative one
backlash = "0 um" # play between motor and load
# home_is_limit = "plus" # its home switch is the motor's plus limit switch, too
# epics.fields = {{ DLLM = 0, DHLM = 100 }} # of its motor record, for `pixstep ioc`
# profiles.line = {profile} # beside this file; for `line make`
# profiles.move = "AccProf-fast-move.csv" # for `move` and `home`: profiles.home

[motors.{key}.limits] # each may be left out
max_speed = "{speed} mm/s"
max_acceleration = "{acceleration} mm/s2"
# max_jerk = "20000 mm/s3"
# start_stop = "4 steps/px" # plain motors turn up to here without a ramp
"""


_SPEED, _ACCELERATION, _STEPS_MM = 30, 500, 400  # mm/s, mm/s2 and steps/mm of a new motor
_BARE = re.compile(r"[A-Za-z0-9_-]+")


def new_text(
    board: str,
    clock_hz: Fraction,
    motors: dict[str, str],
    divider: int | None = None,
    sync: str | None = None,
) -> str:
    """Return a file for a board with motors, kinds by name, on its axes in a row.

    Without a divider a pixel has as many edges of the clock as the accelerations need; with one
    the accelerations are what its pixels allow. `sync` that is None is there as a comment. Raises
    UserError if the board has fewer axes, and for a clock that it cannot follow.
    """
    if len(motors) > boards.load(board).axes:
        raise UserError(f"{len(motors)} motors: {boards.axes_text(board)}")
    made = _filled_text(board, clock_hz, motors, divider, sync)
    found = parse(made)
    smooth = dict.fromkeys(motors, "smooth")  # `limits` tells the shortest smooth line of any motor
    enough = describe.enough_divider(
        parse(_filled_text(board, clock_hz, smooth, divider, sync)), faults=0
    )
    if divider is None and enough and enough > 1:
        made = _filled_text(board, clock_hz, motors, enough, sync)
        found = parse(made)
    elif divider is not None:
        hz = clock_hz / divider
        least = Fraction(describe.LEAST["smooth"], _STEPS_MM)
        speed = max(_SPEED, _two_digits_up(least * hz))
        acceleration = max(_ACCELERATION, _two_digits_up(least * hz**2))
        made = _filled_text(board, clock_hz, motors, divider, sync, speed, acceleration)
        found = parse(made)
    wrong = next(describe.warnings(found), None)
    if wrong:
        would = f": {{divider}} {enough} would do" if enough else ""
        raise UserError(AskedText("{wrong}" + would, wrong=wrong))
    return made


def _two_digits_up(value: Fraction) -> int:
    """Return a figure rounded up to two digits."""
    unit = int("1".ljust(len(str(math.ceil(value))) - 1, "0"))
    return math.ceil(value / unit) * unit


def _filled_text(
    board: str,
    clock_hz: Fraction,
    motors: dict[str, str],
    divider: int | None,
    sync: str | None,
    speed: int = _SPEED,
    acceleration: int = _ACCELERATION,
) -> str:
    first = next(iter(motors))
    key = f"motor = {_quoted(first)} # the motor that lines are for, if no --motor is given\n"
    hz = f"{clock_hz.numerator}/{clock_hz.denominator}".removesuffix("/1")
    head = _HEAD.format(
        hz=hz,
        board=board,
        out_hz=min(max(round(clock_hz), 1), boards.MOST_CLOCK_OUT_HZ),
        motor_key=key,
        divider=f"divider = {divider}" if divider else "# divider = 4",
        sync=f'sync = "{sync}"' if sync else '# sync = "lock"',
    )
    pixel_hz = clock_hz / (divider or 1)
    return head + "".join(
        _MOTOR.format(
            name=name,
            key=name if _BARE.fullmatch(name) else _quoted(name),
            axis=axis,
            kind=kind,
            profile=_quoted(_profile_name(name, pixel_hz)),
            speed=speed,
            acceleration=acceleration,
        )
        for axis, (name, kind) in enumerate(motors.items())
    )


def _quoted(name: str) -> str:
    """Return a printable text as TOML has it."""
    return json.dumps(name, ensure_ascii=False)


def _profile_name(name: str, pixel_hz: Fraction) -> str:
    """Return the name by which `profile make` writes a motor's profile."""
    try:
        return origin.conventional_name(name, pixel_hz, "1")
    except UserError:  # a name that no file can have
        return "profile.PRN"
