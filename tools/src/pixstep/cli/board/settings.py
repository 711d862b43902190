# SPDX-License-Identifier: MIT
"""`pixstep board settings`: export, import, store, defaults, diff."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

import click

from pixstep import atomic
from pixstep.board import settings, settingsfile
from pixstep.board.port import Port
from pixstep.cli.board.group import (
    Units,
    boards,
    one_board,
    port_options,
    unit_option,
    units_option,
)
from pixstep.cli.board.put import ChangedRow, change_text
from pixstep.cli.command import FILE, OUTPUT, command
from pixstep.cli.options import board_rows, deliver_facts, json_option, show_json
from pixstep.errors import RefusedError, UserError

_ADDRESS, _BOARD = "unit_address", "board"
skip_option = click.option(
    "--skip",
    multiple=True,
    metavar="NAME",
    help="Leave this setting as it is; board: take the file of another board; again for more.",
)


@command("export")
@click.argument("file", type=OUTPUT)
@port_options
@unit_option
@json_option
def export_command(file: Path, port: Port, unit: int, as_json: bool) -> None:
    """Write all settings in force to a TOML file.

    Each with what it means; "-" writes to the terminal.
    """
    with one_board(port, unit) as (_found, known):
        found = settings.read(known.board)
    if atomic.is_stdout(file):
        click.echo(settingsfile.text(known.who, found), nl=False)
        return
    settingsfile.write(file, known.who, found)
    facts = {"file": str(file), "unit": unit, "board": known.who.board, "settings": len(found)}
    text = f"{file}: {len(found)} settings of board {unit} ({known.who.board})"
    deliver_facts(facts, text, file, as_json=as_json)


@command("import")
@click.argument("file", type=FILE)
@port_options
@units_option
@skip_option
@click.option("--store", is_flag=True, help="Store the settings in the board's EEPROM afterwards.")
@click.option("--dry-run", is_flag=True, help="Only show what would change.")
@json_option
def import_command(
    file: Path,
    port: Port,
    units: Units,
    skip: tuple[str, ...],
    store: bool,
    dry_run: bool,
    as_json: bool,
) -> None:
    """Set what a TOML file says, all or nothing; read it back.

    The file may hold only some settings; those that it leaves out stay as they are. One that says
    of which board it is goes onto no other; an exported one that was cut off is refused.
    """
    read = settingsfile.read(file)
    wanted = _wanted(read, skip)
    rows = []
    with boards(port, units) as (found, known):
        if _ADDRESS in wanted and len(known) > 1:
            raise UserError(
                f"{file}: several boards cannot have one address: add --skip {_ADDRESS}"
            )
        for item in known if _BOARD not in skip else ():
            read.refuse_other(item.who)
        for item in known if store and not dry_run else ():
            item.board.require("store")
        for item in known:
            old = settings.read(item.board)
            change = settings.changes(old, wanted)
            row: ChangedRow = {
                "unit": item.board.unit,
                "changed": [one.as_json() for one in change],
            }
            if not dry_run:
                with _of_file(file):
                    settings.write(item.board, old, change)
                if store:
                    row["record"] = settings.store(item.board, found.world)
            rows.append(row)
            if not as_json:
                _print(row, dry_run=dry_run)
    if as_json:
        show_json({"file": str(file), "written": not dry_run, "boards": rows})


@contextlib.contextmanager
def _of_file(file: Path) -> Iterator[None]:
    """Say of which file the values are that do not go together."""
    try:
        yield
    except UserError as error:
        raise RefusedError(f"{file}: {error}") from None


@command("store")
@port_options
@units_option
@json_option
def store_command(port: Port, units: Units, as_json: bool) -> None:
    """Store the settings in force: they outlast power."""
    with boards(port, units) as (found, known), board_rows(as_json=as_json) as tell:
        for item in known:
            unit, serial = item.board.unit, settings.store(item.board, found.world)
            tell({"unit": unit, "record": serial}, f"board {unit}: stored as record {serial}")


@command("defaults")
@port_options
@units_option
@click.option("--store", is_flag=True, help="Store them too; else the stored ones return at reset.")
@json_option
def defaults_command(port: Port, units: Units, store: bool, as_json: bool) -> None:
    """Put the default settings into force.

    Address 1, 115200 baud, even parity, 30 Hz and so on.
    """
    with boards(port, units) as (found, known):
        if len(known) > 1:
            raise UserError("one board at a time: by default all have address 1")
        if store:
            known[0].board.require("store")
        settings.use_defaults(known[0].board)
        facts = {"unit": known[0].board.unit}
        text = f"default settings are in force; the board is now unit {known[0].board.unit}"
        if store:
            facts["record"] = settings.store(known[0].board, found.world)
            text += f"\nstored as record {facts['record']}"
    deliver_facts(facts, text, as_json=as_json)


@command("diff")
@click.argument("file", type=FILE, required=False)
@port_options
@unit_option
@json_option
@click.pass_context
def diff_command(
    ctx: click.Context, file: Path | None, port: Port, unit: int, as_json: bool
) -> None:
    """Compare with a TOML file, or with the defaults.

    Exit status 0 if they are equal, 1 if not.
    """
    wanted = settingsfile.read(file).settings if file else settings.defaults()
    with one_board(port, unit) as (_found, known):
        found = settings.changes(wanted, _part(settings.read(known.board), wanted))
    other = str(file) if file else "the defaults"
    if as_json:
        rows = [{"name": one.name, "other": one.old, "board": one.new} for one in found]
        show_json({"unit": unit, "other": other, "different": rows})
    elif not found:
        click.echo(f"board {unit}: no difference to {other}")
    else:
        click.echo(f"{other} -> board {unit}")
        for one in found:
            click.echo(change_text(one.as_json()))
    ctx.exit(1 if found else 0)


def _wanted(read: settingsfile.SettingsFile, skip: tuple[str, ...]) -> dict[str, int]:
    """Return what a file asks for, without what is to be left out."""
    for name in skip:
        if name not in (_BOARD, *settings.defaults()):
            raise UserError(f"--skip {name}: there is no such setting")
    return {name: value for name, value in read.settings.items() if name not in skip}


def _part(values: dict[str, int], names: dict[str, int]) -> dict[str, int]:
    return {name: values[name] for name in names}


def _print(row: ChangedRow, *, dry_run: bool) -> None:
    done = "would change" if dry_run else "changed"
    count = len(row["changed"])
    click.echo(f"board {row['unit']}: {count} setting{'' if count == 1 else 's'} {done}")
    for change in row["changed"]:
        click.echo(f"  {change_text(change)}")
    if "record" in row:
        click.echo(f"  stored as record {row['record']}")
