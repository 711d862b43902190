# SPDX-License-Identifier: MIT
"""`pixstep board get`: registers by name, with units, words, ranges."""

from __future__ import annotations

import click

from pixstep.board import features, values
from pixstep.board import registers as regs
from pixstep.board.device import Board
from pixstep.board.port import Port
from pixstep.board.values import SETTING, Reading
from pixstep.cli.board.group import Units, boards, port_options, units_option
from pixstep.cli.command import command
from pixstep.cli.options import json_option, show_json
from pixstep.simulation.report import WIDE, new_console, new_table


@command("get")
@click.argument("names", metavar="[NAME]...", nargs=-1)
@port_options
@units_option
@json_option
def get_command(names: tuple[str, ...], port: Port, units: Units, as_json: bool) -> None:
    """Read registers by name, or all of them.

    Settings, what the board measures, and its axes'. NAME may have wild cards ('dir_*'), an axis
    ('axis0.position_steps', without the axis all of them); none at all means everything.
    """
    values.select(names, max(regs.AXIS_COUNTS))  # an unknown name before the port is opened
    with boards(port, units) as (_found, known):
        for item in known:
            _require(item.board, names)
        told = [
            (item, values.read(item.board, values.select(names, item.who.axis_count)))
            for item in known
        ]
    if as_json:
        rows = [
            {"unit": item.board.unit, "registers": [reading.as_json() for reading in readings]}
            for item, readings in told
        ]
        show_json({"boards": rows})
        return
    for item, readings in told:
        if len(told) > 1:
            click.echo(f"board {item.board.unit}:")
        _print(readings, full=not names)


def _require(board: Board, names: tuple[str, ...]) -> None:
    """Refuse a register asked for by its name that says nothing on this board."""
    needed = {features.OF_REGISTERS[name] for name in names if name in features.OF_REGISTERS}
    if needed:
        board.require(*sorted(needed))


def _print(readings: list[Reading], *, full: bool) -> None:
    """Print values, and of everything the meanings too."""
    if not full:
        for reading in readings:
            click.echo(text(reading))
        return
    table = new_table("name", "value", "in words", "range", "default", "meaning")
    for column in table.columns:
        column.justify = "left"
        column.no_wrap = False
    table.columns[0].no_wrap = True
    for reading in readings:
        register = reading.item.register
        is_setting = reading.item.kind == SETTING
        table.add_row(
            reading.item.name,
            f"{reading.value}{values.unit_text(register)}",
            reading.words,
            values.range_text(register) if is_setting else "",
            str(register.default) if is_setting else "",
            register.meaning,
        )
    new_console(narrowest=WIDE).print(table, markup=False)


def text(reading: Reading) -> str:
    """Return a value as `name = value unit (words)`."""
    words = f" ({reading.words})" if reading.words else ""
    unit = values.unit_text(reading.item.register)
    return f"{reading.item.name} = {reading.value}{unit}{words}"
