# SPDX-License-Identifier: MIT
"""`pixstep board arm`, `disarm`, `clear`, `enable`, `disable`, `permit`."""

import click

from pixstep.board import run
from pixstep.board.port import Port
from pixstep.cli.board.group import (
    Known,
    Units,
    axes_option,
    axes_text,
    boards,
    each_board,
    note_play,
    note_unattended,
    port_options,
    stopping,
    units_option,
)
from pixstep.cli.command import command
from pixstep.cli.options import board_rows, json_option
from pixstep.errors import UserError

TOKEN = click.IntRange(1, 0xFFFF)


def _simple(name: str, code: str, done: str, text: str) -> click.Command:
    """Return a command that gives one command to some axes of some boards."""

    @command(name, help=text)
    @port_options
    @units_option
    @axes_option
    @json_option
    def simple(port: Port, units: Units, axes: tuple[int, ...], as_json: bool) -> None:
        def give(item: Known) -> None:
            chosen = item.axes(axes)
            run.command(item.board, code, chosen)
            unit = item.board.unit
            tell({"unit": unit, "axes": chosen}, f"board {unit}: {axes_text(chosen)} {done}")

        with board_rows(as_json=as_json) as tell:
            each_board(port, units, give)

    return simple


@command("arm")
@port_options
@units_option
@axes_option
@click.option("--token", type=TOKEN, help="Wait after arming for `go` with this token.")
@json_option
def arm_command(
    port: Port, units: Units, axes: tuple[int, ...], token: int | None, as_json: bool
) -> None:
    """Arm loaded axes by hand, with a token if wanted.

    They start on the next pixel clock edge, or on go if there is a token. `pixstep board start`
    does this for several boards at once. Without --axis all loaded ones. A board that gets no
    request for `bus_timeout_ms` (3 s by default) while an axis is armed or moves stops.
    """
    with boards(port, units) as (_found, known), board_rows(as_json=as_json) as tell:
        for item in known:
            chosen = item.axes(axes) if axes else run.loaded(item.board, item.who.axis_count)
            if not chosen:
                raise UserError(f"board {item.board.unit}: no axis has a line loaded")
            with stopping([run.Lines(item.board, chosen)]):
                run.arm(item.board, chosen, token or 0)
                note_play(item.board, chosen)
            unit = item.board.unit
            tell({"unit": unit, "axes": chosen}, f"board {unit}: {axes_text(chosen)} armed")
            note_unattended(item.board)


@command("clear")
@port_options
@units_option
@json_option
def clear_command(port: Port, units: Units, as_json: bool) -> None:
    """Clear the latched fault.

    Refused while its cause lasts, as a pressed emergency stop does.
    """

    def clear(item: Known) -> None:
        unit, before = item.board.unit, item.board.fault_text()
        run.command(item.board, "clear_fault", [0])
        done = f"cleared: {before}" if before else "no fault was latched"
        tell({"unit": unit, "cleared": before or None}, f"board {unit}: {done}")

    with board_rows(as_json=as_json) as tell:
        each_board(port, units, clear)


@command("permit")
@click.argument("state", type=click.Choice(["on", "off"]))
@port_options
@units_option
@json_option
def permit_command(state: str, port: Port, units: Units, as_json: bool) -> None:
    """Switch the permit output, the gate of a laser or spindle.

    Every fault and every stop switches it off.
    """

    def switch(item: Known) -> None:
        run.command(item.board, f"permit_{state}", [0])
        unit = item.board.unit
        tell({"unit": unit, "permit": state}, f"board {unit}: permit output {state}")

    with board_rows(as_json=as_json) as tell:
        each_board(port, units, switch)


disarm_command = _simple("disarm", "disarm", "disarmed", "Disarm axes and discard their queues.")
enable_command = _simple("enable", "enable", "enabled", "Switch drivers on: their motors hold.")
disable_command = _simple("disable", "disable", "disabled", "Switch drivers of axes at rest off.")
