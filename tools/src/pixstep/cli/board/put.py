# SPDX-License-Identifier: MIT
"""`pixstep board set`: settings by name, checked before they are sent."""

from typing import NotRequired, TypedDict

import click

from pixstep.board import features, settings, values
from pixstep.board import registers as regs
from pixstep.board.device import Board
from pixstep.board.link import World
from pixstep.board.port import Port
from pixstep.board.settings import ChangeData
from pixstep.cli.board.group import Units, boards, port_options, units_option
from pixstep.cli.command import command
from pixstep.cli.options import json_option, show_json
from pixstep.errors import UserError


class ChangedRow(TypedDict):
    """What changed on a board, and the record that was stored if any was."""

    unit: int
    changed: list[ChangeData]
    record: NotRequired[int]


class _SetRow(ChangedRow):
    unchanged: dict[str, int]


@command("set")
@click.argument("assigned", metavar="NAME=VALUE...", nargs=-1, required=True)
@port_options
@units_option
@click.option("--store", is_flag=True, help="Store the settings in the board's EEPROM afterwards.")
@json_option
def set_command(
    assigned: tuple[str, ...], port: Port, units: Units, store: bool, as_json: bool
) -> None:
    """Change settings, all of them in one request: all or none.

    pixel_hz=30000/1001 sets its four words, baud=19200 and parity=N what they say. When address,
    rate or parity change, the next commands need the new ones.
    """
    wanted = values.assignments(assigned)
    rows = []
    with boards(port, units) as (found, known):
        if "unit_address" in wanted and len(known) > 1:
            raise UserError("unit_address: several boards cannot have one address")
        for item in known:
            rows.append(_set(item.board, wanted, found.world, store=store))
            if not as_json:
                _print(rows[-1], several=len(known) > 1)
    if as_json:
        show_json({"boards": rows})


def _set(board: Board, wanted: dict[str, int], world: World, *, store: bool) -> _SetRow:
    """Set one board; return what changed as plain data, the changes themselves as `changes`."""
    unit = board.unit
    needed = {features.OF_REGISTERS[name] for name in wanted if name in features.OF_REGISTERS}
    board.require(*sorted(needed | ({"store"} if store else set())))
    old = settings.read(board)
    found = settings.changes(old, wanted)
    settings.write(board, old, found)
    row: _SetRow = {
        "unit": unit,
        "changed": [change.as_json() for change in found],
        "unchanged": {name: old[name] for name in wanted if old[name] == wanted[name]},
    }
    if store:
        row["record"] = settings.store(board, world)
    return row


def _print(row: _SetRow, *, several: bool) -> None:
    where = f"board {row['unit']}: " if several else ""
    for change in row["changed"]:
        click.echo(where + change_text(change))
    for name, value in row["unchanged"].items():
        click.echo(f"{where}{name} is {value} already")
    if "record" in row:
        click.echo(f"{where}stored as record {row['record']}")


def change_text(row: ChangeData) -> str:
    """Return a change as `name: old -> new unit (words)`."""
    register = values.check(row["name"], row["new"])
    words = regs.words(register, row["new"])
    unit = values.unit_text(register)
    return f"{row['name']}: {row['old']} -> {row['new']}{unit}" + (f" ({words})" if words else "")
