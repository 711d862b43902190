# SPDX-License-Identifier: MIT
"""`pixstep board arm`, `disarm`, `stop`, `clear`, `enable`, `disable`, `permit`."""

import click

from pixstep.board import run
from pixstep.cli.board.group import (
    UNITS,
    Known,
    axes_option,
    boards,
    each_board,
    line_options,
    opened,
    units_option,
)
from pixstep.errors import UserError

TOKEN = click.IntRange(1, 0xFFFF)


def _axes_text(axes: list[int]) -> str:
    return f"axis {axes[0]}" if len(axes) == 1 else f"axes {', '.join(map(str, axes))}"


def _simple(name: str, code: str, done: str, text: str) -> click.Command:
    """Return a command that gives one command to some axes of some boards."""

    @click.command(name, help=text)
    @line_options
    @units_option
    @axes_option
    def simple(line, units, axes):
        each_board(line, units, lambda item: _give(item, code, item.axes(axes), done))

    return simple


def _give(item: Known, code: str, axes: list[int], done: str) -> None:
    """Give a board a command for some axes and say so."""
    run.command(item.board, code, axes)
    click.echo(f"board {item.board.unit}: {_axes_text(axes)} {done}")


@click.command("arm")
@line_options
@units_option
@axes_option
@click.option("--token", type=TOKEN, help="Wait after arming for `go` with this token.")
def arm_command(line, units, axes, token):
    """Arm loaded axes by hand, with a token if wanted.

    They start on the next pixel clock edge, or on go if there is a token. `pixstep board start`
    does this for several boards at once. Without --axis all loaded ones.
    """
    with boards(line, units) as (_found, known):
        for item in known:
            chosen = item.axes(axes) if axes else run.loaded(item.board, item.who.axis_count)
            if not chosen:
                raise UserError(f"board {item.board.unit}: no axis has a line loaded")
            run.arm(item.board, chosen, token or 0)
            click.echo(f"board {item.board.unit}: {_axes_text(chosen)} armed")


@click.command("stop")
@line_options
@click.option("--unit", "units", type=UNITS, help="Addresses.  [default: broadcast to all]")
@axes_option
def stop_command(line, units, axes):
    """Stop what moves, at once, and forget what is queued.

    There is no ramp. Without --unit a broadcast, sent twice: it reaches every board and nobody
    replies. Positions stay known, but a load that is fast may run on.
    """
    if units is None:
        if axes:
            raise UserError("--axis needs --unit: a broadcast stops all axes of all boards")
        with opened(line) as found:
            for _ in range(2):
                found.board(1).stop_all()
        click.echo(f"{line.port}: stop sent to all boards")
        return
    each_board(line, units, lambda item: _give(item, "stop", item.axes(axes), "stopped"))


@click.command("clear")
@line_options
@units_option
def clear_command(line, units):
    """Clear the latched fault.

    Refused while its cause lasts, as a pressed emergency stop does.
    """
    each_board(line, units, _clear)


def _clear(item: Known) -> None:
    before = item.board.fault_text()
    run.command(item.board, "clear_fault", [0])
    done = f"cleared: {before}" if before else "no fault was latched"
    click.echo(f"board {item.board.unit}: {done}")


@click.command("permit")
@click.argument("state", type=click.Choice(["on", "off"]))
@line_options
@units_option
def permit_command(state, line, units):
    """Switch the permit output, the gate of a laser or spindle.

    Every fault switches it off; `pixstep board stop` does not.
    """

    def switch(item: Known) -> None:
        run.command(item.board, f"permit_{state}", [0])
        click.echo(f"board {item.board.unit}: permit output {state}")

    each_board(line, units, switch)


COMMANDS = (
    arm_command,
    _simple(
        "disarm", "disarm", "disarmed", "Take armed axes back and forget what they have queued."
    ),
    stop_command,
    clear_command,
    _simple("enable", "enable", "enabled", "Switch drivers on: their motors hold."),
    _simple("disable", "disable", "disabled", "Switch drivers of axes at rest off."),
    permit_command,
)
