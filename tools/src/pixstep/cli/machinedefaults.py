# SPDX-License-Identifier: MIT
"""Defaults from a machine file: options --machine and --motor, and what they fill in.

`add_options` gives both to a command that has something a machine file knows. An option on
the command line comes first, then an environment variable, then the machine file, then the
default of the command itself. A file is read only when a command asks for one of its values.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from pixstep.cli import motorchoice as words_of_motors
from pixstep.cli.quantities import set_scale
from pixstep.errors import RefusedError, UserError
from pixstep.lines.units import SPEED, Quantity, Scale
from pixstep.machine import finding
from pixstep.operations import motor_choice as motorchoice
from pixstep.operations.motor_choice import Named

if TYPE_CHECKING:
    from pixstep.machine.model import MachineBoard, Motor
    from pixstep.machine.reading import Machine

_FACTS_OF = "pixstep.machine"
_STOP = ["board", "stop"]
_ANY_BOARD = (_STOP, ["board", "info"])
_OTHER_NAMES = {"line sim": ["sim"], "line plan": ["ticks"]}
_BENCH = (["board", "simulate"], ["sim", "board"])
_FIRST_UNIT = "1"  # the default address of commands that act on one board
_FOLDERS = {
    "sim": "run",
    "move": "move",
    "home": "homing",
    "trajectory": "circle",
}  # of results, by the first word
# A folder that only has its name by the file; a letter; a word that texts have anyhow.
_NOT_NAMED = ("out", "parity", "decode")


class Facts(dict[str, object]):
    """What the machine of one command line says, by the names of a command's parameters."""

    def __init__(self, ctx: click.Context):
        super().__init__()
        self.ctx = ctx
        self.named = Named()
        self.words = _words(ctx)
        self.params = {param.name: param for param in ctx.command.params}

    def __contains__(self, name: object) -> bool:
        return self[name] is not None

    def __getitem__(self, name: object) -> object:
        param = self.params.get(name) if isinstance(name, str) else None
        if param is None or name not in _FACTS or self.found is None:
            return None
        try:
            return _FACTS[name](self)
        except UserError:
            if param.required or self.named.any or name == "axis":
                raise
            return None

    @property
    def machine(self) -> Machine:
        """The machine in force, where a fact of it is wanted: then there is one."""
        if self.found is None:
            raise UserError("no machine file")
        return self.found

    @cached_property
    def found(self) -> Machine | None:
        """The machine in force, None if there is none."""
        path = finding.find(self.named.machine)
        if path is None and self.named.motors:
            raise UserError(
                f"--motor {self.named.motors[0]}: no machine file: --machine FILE, "
                f"{finding.VARIABLE}, or {finding.NAME} in this folder "
                f"(`pixstep machine new` begins one)"
            )
        if path is None:
            return None
        machine = self._load(path)
        if machine is not None:
            self._choose(machine)
        return machine

    def _choose(self, machine: Machine) -> None:
        """Take the motors that are named; one that the file does not have is refused."""
        if self.named.own in machine.motors:
            self.named.motors = (self.named.own,)
        if self.words in _ANY_BOARD:
            self.named.units = ()
        if self.words == _STOP and not self.named.motors:
            self.named.axes = ()  # any axis can be stopped, whatever the file has
        if self.named.any:
            self.motors = motorchoice.choose(machine, self.named)

    def _load(self, path: Path) -> Machine | None:
        """Read a file; one that is wrong must not keep anybody from stopping a board."""
        from pixstep.machine import reading  # pydantic takes a while to load

        try:
            return reading.Machine.load(path)
        except UserError as error:
            if self.words != _STOP or self.named.motors:
                raise
            click.echo(f"note: {error}: not used", err=True)
            return None

    @cached_property
    def motors(self) -> list[Motor]:
        """The motors chosen by --motor or --axis, else the one that lines are for."""
        return motorchoice.choose(self.machine, self.named)

    @property
    def motor(self) -> Motor:
        """The only motor. Raises UserError if several are chosen."""
        if len(self.motors) > 1:
            names = " and ".join(motor.name for motor in self.motors)
            raise UserError(f"motors {names}: this command takes one motor")
        return self.motors[0]

    @property
    def board(self) -> MachineBoard:
        """The board of all motors that are chosen."""
        boards = self.boards
        if len(boards) > 1:
            raise UserError(f"motors on boards {' and '.join(sorted(boards))}: a run has one board")
        return next(iter(boards.values()))

    @property
    def boards(self) -> dict[str, MachineBoard]:
        """The boards of the motors that are chosen, by name."""
        machine = self.machine
        if not self.named.any:
            there = motorchoice.boards_at(machine, self.named.units)
            if there or len(machine.boards) == 1:
                return there or machine.boards
        return {machine.board_name(motor): machine.board_of(motor) for motor in self.motors}

    def scale(self) -> Scale | None:
        """Return steps per unit of length; None without a machine, or if motors differ."""
        if self.found is None:
            return None
        scales = {motor.steps_per_unit for motor in self.motors}
        return scales.pop() if len(scales) == 1 else None

    def said(self, name: str) -> object:
        """Return what a parameter is so far; None if nothing says it, or not yet."""
        value = self.ctx.params.get(name)
        return value if isinstance(value, (str, tuple, bool, Path)) else None

    def several(self, name: str) -> tuple[object, ...]:
        """Return the values that a parameter has so far, none or one or more."""
        value = self.said(name)
        if isinstance(value, tuple):
            return value
        return () if value is None else (value,)

    def multiple(self, name: str) -> bool:
        """True if a parameter of the command may be given several times."""
        return bool(getattr(self.params[name], "multiple", False))

    def other_kind(self) -> bool:
        """True if the command line says another kind of motor than the file."""
        words = ("plain",) if self.said("plain") else self.several("decode")
        return bool(set(words) - {motor.decode for motor in self.motors})


def told(ctx: click.Context | None) -> dict[str, str | None]:
    """Return the machine file that gave a command a default, for its JSON; None if none did.

    A command that no file could give any has nothing to tell.
    """
    if ctx is None or _FACTS_OF not in ctx.meta:
        return {}
    machine = used(ctx)
    return {"machine": str(machine.path) if machine else None}


def used(ctx: click.Context) -> Machine | None:
    """Return the machine that a command has asked for a default; it is not read only for this."""
    facts = ctx.meta.get(_FACTS_OF)
    return None if facts is None else vars(facts).get("found")


def compare_board(ctx: click.Context, port: str, unit: int, kind: str) -> None:
    """Refuse a connected board of another kind than the machine file that is used says.

    The file says it of the board at this address, and of the one whose motor is meant. Stopping
    goes on, and so does what shows which board it is: both only note it.
    """
    facts: Facts | None = ctx.meta.get(_FACTS_OF)
    if facts is None:
        return
    machine = used(ctx)
    if machine is None:
        return
    for name in _boards_meant(facts, machine, port, unit):
        if machine.boards[name].kind == kind:
            continue
        said = f"{machine.path} has boards.{name} as a {machine.boards[name].kind}"
        text = f"board {unit} on {port} is a {kind}; {said}"
        if _words(ctx) not in _ANY_BOARD:
            raise RefusedError(text)
        click.echo(f"note: {text}", err=True)


def _boards_meant(facts: Facts, machine: Machine, port: str, unit: int) -> list[str]:
    """Return the file's boards that a connected one must be like, by name.

    A board without a port in the file is on every port. A motor of another board that the command
    line has the address of says nothing of this one.
    """
    place = [
        name
        for name, board in machine.boards.items()
        if board.port in (None, port) and board.unit == unit
    ]
    motors = facts.motors if facts.named.any or _by_motor(facts.ctx) else []
    others = motorchoice.boards_at(machine, [one for one in facts.named.units if one != unit])
    named = [name for name in map(machine.board_name, motors) if name not in others]
    return list(dict.fromkeys([*place, *named]))


def _by_motor(ctx: click.Context) -> bool:
    """True if a parameter of a command comes from a motor of the machine file."""
    return any(name not in _NO_MOTOR_S and by_machine(ctx, name) for name in _FACTS)


def motors_in_force(ctx: click.Context) -> list[Motor]:
    """Return the motors of a command; none without a file, or if nothing chooses one of several.

    A file from which no default was taken is not read for that.
    """
    if used(ctx) is None:
        return []
    try:
        return facts_of(ctx).motors
    except UserError:
        return []


def motor_in_force(ctx: click.Context) -> tuple[Path, str] | None:
    """Return the machine file of a command and the name of its motor; None without a file.

    Raises UserError if the file has several motors and none is chosen.
    """
    facts = facts_of(ctx)
    return (facts.found.path, facts.motor.name) if facts.found else None


def scales(ctx: click.Context) -> dict[int, Scale]:
    """Return the scales of the motors on the board that is meant, by axis; none without a file."""
    facts = facts_of(ctx)
    try:
        if facts.found is None:
            return {}
        board = facts.board
    except UserError:
        return {}
    return {
        motor.axis: motor.steps_per_unit
        for motor in facts.machine.motors.values()
        if motor.steps_per_unit and facts.machine.board_of(motor) is board
    }


def in_force(ctx: click.Context) -> Machine | None:
    """Return the machine of a command line; None without a file."""
    return facts_of(ctx).found


def units_on(ctx: click.Context, port: str) -> tuple[int, ...]:
    """Return the addresses that the machine file of a command line gives boards on a port."""
    facts: Facts | None = ctx.meta.get(_FACTS_OF)
    try:
        used = None if facts is None else facts.found
    except UserError:  # a mistake in the file keeps nobody from looking
        used = None
    if used is None:
        return ()
    boards = used.boards.values()
    return tuple(sorted({board.unit for board in boards if board.port in (None, port)}))


def by_machine(ctx: click.Context, name: str) -> bool:
    """True if the value of a parameter comes from the machine file."""
    return ctx.get_parameter_source(name) == ParameterSource.DEFAULT_MAP


def origin(ctx: click.Context, text: str | None = None) -> str:
    """Return ` (... from machine.toml)` for defaults of the file that a text names, else "".

    Without a text something of the file is meant anyhow.
    """
    machine = used(ctx)
    if machine is None or str(machine.path) in (text or ""):
        return ""
    if text is None:
        return f" (from {machine.path})"
    named = [
        _option(param)
        for param in ctx.command.params
        if by_machine(ctx, param.name or "") and _names(text, param, ctx.params.get(param.name))
    ]
    return f" ({', '.join(named)} from {machine.path})" if named else ""


def _option(param: click.Parameter) -> str:
    return max(param.opts, key=len)


def _names(text: str, param: click.Parameter, value: object) -> bool:
    """True if a text has a value of a parameter; of a number beside the parameter's name."""
    word = (param.name or "").removesuffix("s")
    values = value if isinstance(value, tuple) else (value,)
    return word not in _NOT_NAMED and any(
        re.search(_pattern(word, one), text) for one in values if one is not None
    )


def _pattern(word: str, value: object) -> str:
    """Return what finds a value in a text as a word of its own."""
    if isinstance(value, Fraction):
        return rf"(?<![\w.]){re.escape(f'{float(value):.10g}')} Hz"
    if isinstance(value, int):
        return rf"\b{word}s?\W+{value}\b(?!\.)|(?<![\w.]){value} {word}s?\b"
    return rf"(?<![\w./-]){re.escape(str(getattr(value, 'text', value)))}(?![\w/-])"


def _pixel_hz(facts: Facts) -> Fraction:
    """Of the clock's edges where a command divides them or makes a clock, else of pixels."""
    edges = "divider" in facts.params or facts.words in _BENCH
    return facts.machine.clock_hz if edges else facts.machine.pixel_hz


def _decode(facts: Facts) -> object:
    """Every line has a motor: the one there is serves one line only."""
    asked = facts.params["decode"].required or facts.named.any or facts.words == ["line", "make"]
    if facts.said("plain") or not (asked or "home" in facts.words):
        return None
    if facts.words == ["profile", "make"] and not facts.said("csv"):
        return None
    if not facts.multiple("decode"):
        return facts.motor.decode
    return [motor.decode for motor in facts.motors]


def _backlash(facts: Facts) -> object:
    """Only smooth lines take up backlash."""
    if facts.other_kind():
        return None
    steps = [motor.backlash_steps if motor.smooth else 0 for motor in facts.motors]
    return steps if facts.multiple("backlash") else steps[0]


def _negative(facts: Facts) -> bool | None:
    """None for lines of both directions: `directions.negatives` knows that of each."""
    if facts.other_kind():
        return None
    smooth = [motor.negative for motor in facts.motors if motor.smooth]
    if facts.words[0] == "line":
        return facts.motor.negative
    return any(smooth) if len(set(smooth)) < 2 else None


def _axis(facts: Facts) -> object:
    """The axes of the motors, in the order of their lines; those of a table are the board's."""
    if facts.named.table and not facts.named.any:
        return None
    axes = [motor.axis for motor in facts.motors]
    return axes if facts.multiple("axis") else facts.motor.axis


def _axes(facts: Facts) -> list[int] | None:
    """Which axes a command acts on, if --motor says so."""
    if not facts.multiple("axes"):
        return None
    return [motor.axis for motor in facts.motors] if facts.named.any else None


def _units(facts: Facts) -> str | None:
    """One address where a command wants one; what asks or stops all boards goes on doing so."""
    if facts.params["units"].default != _FIRST_UNIT and not facts.named.any:
        return None
    return str(facts.board.unit)


def _profile(facts: Facts) -> Path | None:
    """A PRN for lines; one for moves or homing."""
    words = ["home"] if "measure-play" in facts.words else facts.words
    use = next((word for word in ("line", "home") if word in words), "move")
    return facts.machine.profile(facts.motor, use)


def _of_line(key: str) -> Callable[[Facts], object]:
    def value(facts: Facts) -> object:
        return getattr(facts.machine.line, key) if facts.words == ["line", "make"] else None

    return value


def _of_board(key: str) -> Callable[[Facts], object]:
    """Of the board; the bus and how it is spoken to may be the same for several."""

    def value(facts: Facts) -> object:
        values = {getattr(board, key) for board in facts.boards.values()}
        return values.pop() if len(values) == 1 else getattr(facts.board, key)

    return value


def _limit(key: str) -> Callable[[Facts], object]:
    return lambda facts: facts.motor.limit(key)


def _top_speed(facts: Facts) -> Quantity | None:
    """The highest speed of a profile within the motor's limit: even, in steps/pixel."""
    limit = facts.motor.limit("max_speed")
    if limit is None:
        return None
    speed = limit.per_pixel(facts.machine.pixel_hz) // 2 * 2
    return Quantity(Fraction(speed), SPEED, False, str(speed))


def _play(facts: Facts) -> object:
    """Of one motor; of a table's axes only if --motor says which they are."""
    if not facts.multiple("play"):
        return facts.motor.backlash_steps or None
    return [motor.backlash_steps for motor in facts.motors] if facts.named.any else None


def _folder(facts: Facts) -> Path | None:
    return Path(_FOLDERS[facts.words[0]]) if facts.words[0] in _FOLDERS else None


_FACTS: dict[str, Callable[[Facts], object]] = {
    "pixel_hz": _pixel_hz,
    "divider": lambda facts: facts.machine.clock.divider,
    "sync": lambda facts: facts.machine.clock.sync,
    "gate_edges": lambda facts: facts.machine.clock.gate_edges,
    "board": _of_board("kind"),
    "port": _of_board("port"),
    "baud": _of_board("baud"),
    "parity": _of_board("parity"),
    "unit": _of_board("unit"),
    "units": _units,
    "axis": _axis,
    "axes": _axes,
    "decode": _decode,
    "backlash": _backlash,
    "negative": _negative,
    "play": _play,
    "prn": _profile,
    "profile": _profile,
    "pixels": _of_line("pixels"),
    "lead_in": _of_line("lead_in"),
    "top_speed": _top_speed,
    "max_speed": _limit("max_speed"),
    "max_acceleration": _limit("max_acceleration"),
    "max_jerk": _limit("max_jerk"),
    "start_stop": _limit("start_stop"),
    "home_is_limit": lambda facts: facts.motor.home_is_limit,
    "out": _folder,
}
_NO_MOTOR_S = (
    "pixel_hz", "divider", "sync", "gate_edges", "board", "port", "baud", "parity", "unit", "units",
)  # fmt: skip


def refuse_several(
    _ctx: click.Context, _param: click.Parameter, value: tuple[str, ...]
) -> tuple[str, ...]:
    """Refuse a second --motor of a command that takes one, which click would take alone."""
    if len(value) > 1:
        raise UserError(f"--motor {' --motor '.join(value)}: this command takes one motor")
    return value


def add_options(command: click.Command) -> None:
    """Give --machine and --motor to a command, if a machine file knows any of its values.

    A command's own --motor keeps its meaning and chooses the motor too. Calling it again for a
    command that has two names changes nothing.
    """
    names = {param.name for param in command.params}
    if "machine" in names or not names & _FACTS.keys():
        return
    many = any(
        param.name in ("decode", "play") and getattr(param, "multiple", False)
        for param in command.params
    )
    if "motor" not in names:
        command.params.append(
            click.Option(
                ["--motor"], metavar="NAME", multiple=True, expose_value=False,
                callback=None if many else refuse_several,
                help=f"Motor of the machine file{', once for each line' if many else ''}.",
            )
        )  # fmt: skip
    command.params.append(
        click.Option(
            ["--machine"], metavar="FILE", envvar=finding.VARIABLE, show_envvar=True,
            expose_value=False,
            help=f"Machine file with defaults, or `none`.  [default: {finding.NAME} in the "
            f"current folder]",
        )
    )  # fmt: skip


def note_words(ctx: click.Context, args: Sequence[str]) -> None:
    """Note what a command line says of motors, before it is read as a whole.

    Raises UserError for motors that it names and that the file does not have, and for names that
    contradict each other; the file is read for that even if nothing else is asked of it.
    """
    if ctx.resilient_parsing or not {"machine", "motor"} <= {
        param.name for param in ctx.command.params
    }:
        return
    named = words_of_motors.read(ctx, args)
    if named is None:
        return
    facts = facts_of(ctx)
    facts.named = named
    if named.any:
        _ = facts.found


def facts_of(ctx: click.Context) -> Facts:
    """Return the facts of a command line, in force from now on."""
    facts = ctx.meta.get(_FACTS_OF)
    if facts is None or facts.ctx is not ctx:
        facts = Facts(ctx)
        ctx.meta[_FACTS_OF] = ctx.default_map = facts
        set_scale(ctx, facts.scale)
    return facts


def hold(ctx: click.Context, facts: Any) -> None:
    """Let what is told of a command line know the facts of its request."""
    facts.ctx, facts.words = ctx, _words(ctx)
    ctx.meta[_FACTS_OF] = facts


def refuse_unknown(ctx: click.Context) -> None:
    """Refuse a machine file that the command line names, also if nothing needs it."""
    facts: Facts | None = ctx.meta.get(_FACTS_OF)
    if facts is None or facts.ctx is not ctx:
        return
    if ctx.get_parameter_source("machine") == ParameterSource.COMMANDLINE:
        _ = facts.found


def _words(ctx: click.Context) -> list[str]:
    """Return the words of a command: ["line", "make"]."""
    words: list[str] = []
    while ctx.parent is not None:
        words.insert(0, ctx.info_name or "")
        ctx = ctx.parent
    return _OTHER_NAMES.get(" ".join(words), words)
