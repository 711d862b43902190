# SPDX-License-Identifier: MIT
"""`pixstep board stop`: one stop, then a look at what rests."""

import click

from pixstep.board import run
from pixstep.board.client import BoardError
from pixstep.board.connection import Connection
from pixstep.cli.board.group import ALL, UNITS, Known, axes_option, each_of, line_options, opened
from pixstep.cli.command import command, complain
from pixstep.errors import UserError


@command("stop")
@line_options
@click.option("--unit", "units", type=UNITS, help="Addresses.  [default: broadcast to all]")
@axes_option
@click.option(
    "--look/--no-look",
    default=True,
    show_default=True,
    help="Ask the boards afterwards whether they rest.",
)
def stop_command(line, units, axes, look):
    """Stop what moves, at once, and forget what is queued.

    There is no ramp; the permit output goes off. Without --unit a broadcast, to which nobody
    replies; then it looks for boards at all addresses, which takes up to 20 s (the boards rest
    meanwhile), and stops one by its address that has not heard. Positions stay known, but a load
    that is fast may run on. Exit status 0 if everything rests as far as was looked, else 1.
    """
    if units is None and axes:
        raise UserError("--axis needs --unit: a broadcast stops all axes of all boards")
    with opened(line) as found:
        if units is None:
            found.board(1).stop_all()
            click.echo(f"{line.port}: stop sent to all boards")
            if look:
                each_of(found, ALL, lambda item: _look_again(found, item))
            return
        each_of(found, units, lambda item: _stop(found, item, item.axes(axes), look=look))


def _stop(found: Connection, item: Known, axes: list[int], *, look: bool) -> None:
    """Stop axes of a board."""
    run.stop_axes(item.board, axes)
    if look:
        _tell(item, run.rests(item.board, axes, found.world))
    else:
        click.echo(f"board {item.board.unit}: stop acknowledged")


def _look_again(found: Connection, item: Known) -> None:
    """Look at a board after a broadcast; stop by its address what still moves."""
    axes = item.axes(())
    rests = run.rests(item.board, axes, found.world)
    moving = [axis for axis, one in rests.items() if not one.at_rest]
    if moving:
        complain(BoardError(f"board {item.board.unit}: it has not heard the broadcast"))
        run.stop_axes(item.board, moving)
        rests = run.rests(item.board, axes, found.world)
    _tell(item, rests)


def _tell(item: Known, rests: dict[int, run.Rest]) -> None:
    """Say where the axes of a board rest; raises BoardError if one does not."""
    unit = item.board.unit
    where = ", ".join(
        f"axis {axis} at position {one.position_steps}"
        for axis, one in rests.items()
        if one.at_rest
    )
    if where:
        click.echo(f"board {unit}: at rest: {where}")
    moving = [
        f"axis {axis} is {one.state} at position {one.position_steps}"
        for axis, one in rests.items()
        if not one.at_rest
    ]
    if moving:
        raise BoardError(f"board {unit}: NOT at rest: {', '.join(moving)}")
