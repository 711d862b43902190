# SPDX-License-Identifier: MIT
"""`pixstep machine`: begin, check and show a machine file."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pixstep import atomic
from pixstep.board import boards
from pixstep.board import registers as regs
from pixstep.cli.command import OUTPUT, command
from pixstep.cli.options import (
    deliver_facts,
    json_option,
    pixel_hz_option,
    say,
    show_json,
)
from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.units import number_text
from pixstep.machine import finding
from pixstep.operations.result import STATUSES, VERDICTS
from pixstep.profiles.madefor import MOST_EDGES
from pixstep.simulation.report import new_console, new_table

if TYPE_CHECKING:
    import rich.console
    import rich.table

    from pixstep.machine.model import Clock
    from pixstep.machine.reading import Machine

_KINDS = (SMOOTH, PLAIN)
_file_argument = click.argument(
    "file", metavar="[FILE]", required=False, envvar=finding.VARIABLE, type=str
)


@command("new")
@click.option("--board", type=click.Choice(boards.BOARD_NAMES), required=True)
@pixel_hz_option
@click.option(
    "--divider", type=click.IntRange(1, MOST_EDGES), metavar="M",
    help="Edges of the pixel clock in a pixel.  [default: 1]",
)  # fmt: skip
@click.option(
    "--sync", type=click.Choice(list(regs.SYNCS)),
    help="What lines are to the pixel clock.  [default: start]",
)  # fmt: skip
@click.option(
    "--motor", "motors", multiple=True, metavar="NAME:KIND",
    help="A motor, as M39:smooth or M40:plain; again for more.  [default: M39:smooth]",
)  # fmt: skip
@click.option(
    "-o", "--output", type=OUTPUT, default=finding.NAME, show_default=True, help="File to write."
)
@json_option
def machine_new(
    board: str,
    pixel_hz: Fraction,
    divider: int | None,
    sync: str | None,
    motors: tuple[str, ...],
    output: Path,
    as_json: bool,
) -> None:
    """Begin a machine file: valid as it is, with a comment for every key."""
    from pixstep.machine import template

    made = template.text(board, pixel_hz, _motors(motors), divider, sync)
    atomic.write_text(output, made)
    text = f"{output}: edit it, then `pixstep machine check`"
    deliver_facts({"machine": str(output)}, text, output, as_json=as_json)


@command("check")
@_file_argument
@json_option
@click.pass_context
def machine_check(ctx: click.Context, file: str | None, as_json: bool) -> None:
    """Check a machine file: every mistake with its line, key and value.

    Exit status 0 fine, 1 warnings (what a board cannot do), 3 refused. Profiles that are not there
    yet are noted: they are made with the machine file's help.
    """
    path = _path(file)
    from pixstep.machine import describe, reading

    errors, warnings, notes = reading.problems(path), [], []
    if not errors:
        found = reading.Machine.load(path)
        warnings, notes = list(describe.warnings(found)), list(describe.notes(found))
    severity = 2 if errors else int(bool(warnings))
    verdict = VERDICTS[severity]
    if as_json:
        report = {"machine": str(path), "verdict": verdict}
        show_json(report | {"errors": errors, "warnings": warnings, "notes": notes})
    else:
        for text in errors:
            click.echo(text)
        for text in warnings:
            click.echo(f"{path}: warning: {text}")
        say(f"{path}: {text}" for text in notes)
        click.echo(f"{path}: {verdict}")
    ctx.exit(STATUSES[severity])


@command("show")
@_file_argument
@json_option
def machine_show(file: str | None, as_json: bool) -> None:
    """Show the machine in force: its file, clock, boards and motors, in steps and pixels."""
    from pixstep.machine import describe, reading

    found = reading.Machine.load(_path(file))
    if as_json:
        show_json(describe.as_json(found))
        return
    console = new_console()
    console.print(
        f"{found.path}: {_clock_text(found.clock)}, lines for "
        f"{found.line.motor or ', '.join(found.motors)}", markup=False, soft_wrap=True,
    )  # fmt: skip
    console.print(_boards_table(found))
    console.print(_motors_table(found))
    console.print("play: steps; speed, accel: limits in steps/px and steps/px2")


def _clock_text(clock: Clock) -> str:
    """Return the clock, and what pixels and lines are to it where the file says so."""
    text = f"{float(clock.pixel):.10g} Hz"
    if clock.edges > 1:
        text += f", {clock.edges} clock edges a pixel"
    said = {"free": "free of the clock", "start": "on its edge", "lock": "locked to it"}
    if clock.gate_edges:
        text += f", gated: line zero {clock.gate_edges} edges behind a burst's first"
    return text + (f", lines {said[clock.sync]}" if clock.sync else "")


def _path(given: str | None) -> Path:
    """Return the file in force. Raises UserError if there is none."""
    path = finding.find(given)
    if path is None:
        raise UserError(
            f"no {finding.NAME} in this folder, and none named: `pixstep machine new` begins one"
        )
    return path


def _motors(texts: tuple[str, ...]) -> dict[str, str]:
    """Return the kinds of motors by name."""
    kinds: dict[str, str] = {}
    for text in texts or ("M39:smooth",):
        name, colon, kind = text.rpartition(":")
        if not colon or kind not in _KINDS or not name.strip() or not name.isprintable():
            raise UserError(f"--motor {text}: expected NAME:KIND, as M39:smooth or M40:plain")
        if name in kinds:
            raise UserError(f"--motor {text}: {name} is there already")
        kinds[name] = kind
    return kinds


def _boards_table(found: Machine) -> rich.table.Table:
    table = new_table("board", "kind", "port", "unit", "baud", "parity")
    for name, board in found.boards.items():
        values = board.model_dump().values()
        table.add_row(name, *("-" if value is None else str(value) for value in values))
    return table


def _motors_table(found: Machine) -> rich.table.Table:
    """Return a row a motor; limits per pixel, as commands use them."""
    table = new_table(
        "motor", "board", "axis", "kind", "dir", "steps per", "play", "speed", "accel"
    )
    for name, motor in found.motors.items():
        scale = motor.steps_per_unit
        limits = (
            limit.per_pixel(found.pixel_hz) if limit else None
            for limit in (motor.limit("max_speed"), motor.limit("max_acceleration"))
        )
        table.add_row(
            name, found.board_name(motor), str(motor.axis), motor.kind, motor.direction,
            f"{_text(float(scale.steps_per_unit))}/{scale.length}" if scale else "-",
            str(motor.backlash_steps),
            *("-" if limit is None else _text(float(limit)) for limit in limits),
        )  # fmt: skip
    return table


def _text(value: float) -> str:
    return number_text(Fraction(value))
