# SPDX-License-Identifier: MIT
"""`pixstep board stop`: one stop, then a look at what rests."""

import click

from pixstep.board import run
from pixstep.board.errors import BoardError
from pixstep.board.link import Link
from pixstep.board.port import Port
from pixstep.cli.board.group import (
    ALL,
    UNITS,
    Known,
    Units,
    axes_option,
    each_of,
    opened,
    port_options,
)
from pixstep.cli.command import command
from pixstep.cli.failures import complain
from pixstep.cli.options import Tell, board_rows, json_option
from pixstep.errors import UserError


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
def stop_command(
    port: Port, units: Units | None, axes: tuple[int, ...], look: bool, as_json: bool
) -> None:
    """Stop what moves, at once, and forget what is queued.

    There is no ramp; the permit output goes off. Without --unit a broadcast, to which nobody
    replies; then it looks for boards at all addresses, which takes up to 20 s (the boards rest
    meanwhile), and stops one by its address that has not heard. Positions stay known, but a load
    that is fast may run on. Exit status 0 if everything rests as far as was looked, else 1.
    """
    if units is None and axes:
        raise UserError("--axis needs --unit: a broadcast stops all axes of all boards")
    with opened(port) as found, board_rows(as_json=as_json) as tell:
        if units is None:
            found.board(1).stop_all()
            if not as_json:
                click.echo(f"{port.name}: stop sent to all boards")
            if look:
                each_of(found, ALL, lambda item: _look_again(found, item, tell))
            return
        each_of(found, units, lambda item: _stop(found, item, item.axes(axes), tell, look=look))


def _stop(found: Link, item: Known, axes: list[int], tell: Tell, *, look: bool) -> None:
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
