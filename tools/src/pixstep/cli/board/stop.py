# SPDX-License-Identifier: MIT
"""`pixstep board stop`: one stop, then a look at what rests."""

import click

from pixstep.board import modbus, run
from pixstep.board.device import Board
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.port import Port, PortBusyError
from pixstep.cli import machinedefaults
from pixstep.cli.board.group import (
    ALL,
    UNITS,
    Known,
    Units,
    axes_option,
    each_of,
    opened,
    port_options,
    present,
)
from pixstep.cli.command import command
from pixstep.cli.failures import complain
from pixstep.cli.options import Tell, board_rows, json_option
from pixstep.errors import UserError

_NEAR = range(1, 9)  # addresses that are looked at without being asked to
_NEAR_S = 0.15  # that each of them has, so that a busy computer misses none


@command("stop")
@port_options
@click.option("--unit", "units", type=UNITS, help="Addresses.  [default: broadcast to all]")
@axes_option
@click.option(
    "--look/--no-look",
    default=True,
    show_default=True,
    help="Ask the boards afterwards whether they rest.",
)
@json_option
@click.pass_context
def stop_command(
    ctx: click.Context,
    port: Port,
    units: Units | None,
    axes: tuple[int, ...],
    look: bool,
    as_json: bool,
) -> None:
    """Stop what moves, at once, and forget what is queued.

    There is no ramp; the permit output goes off. Without --unit a broadcast, to which nobody
    replies, goes out before anything else, also beside another program that has the port open.
    Then the boards at addresses 1 to 8 and those of the machine file are looked at, with --unit all
    those at every address (20 s), and one that has not heard is stopped by its address. Positions
    stay known, but a load that is fast may run on. Exit status 0 if everything rests as far as was
    looked, else 1.
    """
    if units is None and axes:
        raise UserError("--axis needs --unit: a broadcast stops all axes of all boards")
    everyone = units is None or (units == ALL and not axes)

    def stop_all(found: Link) -> None:
        found.board(1).stop_all()
        if not as_json:
            click.echo(f"{port.name}: stop sent to all boards")

    try:
        with (
            opened(port, stop_all if everyone else _nothing) as found,
            board_rows(as_json=as_json) as tell,
        ):
            if units is not None and not everyone:
                each_of(found, units, lambda item: _stop(found, item, item.axes(axes), tell, look))
            elif look:
                there = _those_there(found, units, machinedefaults.units_on(ctx, port.name))
                each_of(found, there, lambda item: _look_again(found, item, tell))
    except PortBusyError:
        if not everyone:
            raise
        _stop_beside(port, look=look, as_json=as_json)


def _nothing(found: Link) -> None:
    """Do nothing before boards are stopped by their addresses."""


def _stop_beside(port: Port, *, look: bool, as_json: bool) -> None:
    """Send the broadcast on a port that another program has open; nobody can be asked then."""
    beside = modbus.Beside()
    Board(beside).stop_all()
    port.send_beside(beside.frames)
    text = f"{port.name}: in use by another program: stop sent to all boards beside it"
    if look:
        raise BoardError(f"{text}, nobody has looked whether they rest")
    if not as_json:
        click.echo(text)


def _those_there(found: Link, units: Units | None, known: tuple[int, ...]) -> tuple[int, ...]:
    """Return the addresses that answer: of all, or of those near at hand and those known."""
    if units == ALL:
        return present(found)
    wanted = sorted({*_NEAR, *known})
    last = _NEAR[-1]
    others = "".join(f", {unit}" for unit in wanted if unit > last)
    return present(
        found,
        wanted,
        _NEAR_S,
        f"at addresses 1 to {last}{others}: `pixstep board stop --unit all` looks at every one",
    )


def _stop(found: Link, item: Known, axes: list[int], tell: Tell, look: bool) -> None:
    """Stop axes of a board."""
    run.stop_axes(item.board, axes)
    if look:
        _tell(item, run.rests(item.board, axes, found.world), tell)
    else:
        unit = item.board.unit
        tell({"unit": unit, "axes": axes}, f"board {unit}: stop acknowledged")


def _look_again(found: Link, item: Known, tell: Tell) -> None:
    """Look at a board after a broadcast; stop by its address what still moves."""
    axes = item.axes(())
    rests = run.rests(item.board, axes, found.world)
    moving = [axis for axis, one in rests.items() if not one.at_rest]
    if moving:
        complain(BoardError(f"board {item.board.unit}: it has not heard the broadcast"))
        run.stop_axes(item.board, moving)
        rests = run.rests(item.board, axes, found.world)
    _tell(item, rests, tell)


def _tell(item: Known, rests: dict[int, run.Rest], tell: Tell) -> None:
    """Say where the axes of a board rest; raises BoardError if one does not."""
    unit = item.board.unit
    rows = [
        {"axis": axis, "at_rest": one.at_rest, "position_steps": one.position_steps}
        for axis, one in rests.items()
    ]
    where = ", ".join(
        f"axis {row['axis']} at position {row['position_steps']}" for row in rows if row["at_rest"]
    )
    if where:
        tell({"unit": unit, "axes": rows}, f"board {unit}: at rest: {where}")
    moving = [
        f"axis {axis} is {one.state} at position {one.position_steps}"
        for axis, one in rests.items()
        if not one.at_rest
    ]
    if moving:
        raise BoardError(f"board {unit}: NOT at rest: {', '.join(moving)}")
