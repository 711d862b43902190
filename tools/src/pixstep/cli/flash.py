# SPDX-License-Identifier: MIT
"""`pixstep flash`: firmware onto a board."""

import shlex

import click

from pixstep.board import connection, flash, transport
from pixstep.board.boards import BOARD_NAMES
from pixstep.board.client import BoardError
from pixstep.board.connection import PortOptions
from pixstep.board.flash import FlashError, Image
from pixstep.board.port import PARITIES
from pixstep.cli.options import FILE, say
from pixstep.errors import UserError


@click.command("flash")
@click.option("--board", type=click.Choice(BOARD_NAMES), required=True)
@click.option("--port", required=True, envvar="PIXSTEP_PORT", show_envvar=True)
@click.option("--hex", "hex_file", type=FILE, help="Image to write.  [default: the one built here]")
@click.option("--verify", is_flag=True, help="Only compare the board's flash with the image.")
@click.option("--dry-run", is_flag=True, help="Print avrdude's command line and do nothing.")
@click.option(
    "--ask/--no-ask",
    default=True,
    show_default=True,
    help="Ask the board afterwards what it is.",
)
@click.option("--unit", type=click.IntRange(1, 247), default=1, show_default=True)
@click.option("--baud", type=int, default=transport.BAUD, show_default=True, help="To ask at.")
@click.option(
    "--parity",
    type=click.Choice(PARITIES, case_sensitive=False),
    default="E",
    show_default=True,
    help="To ask with.",
)
@click.pass_context
def flash_command(ctx, board, port, hex_file, verify, dry_run, ask, unit, baud, parity):
    """Write the firmware to a board by avrdude through its boot loader, then ask what it is.

    Builds nothing: tools/build does. Settings stored on the board stay; where it has another
    address or rate since, give them, or --no-ask. docs/FLASHING.md has the rest.
    """
    image = flash.read_image(hex_file or flash.built_image(board))
    if image.board != board:
        raise UserError(f"{image.path}: an image for the {image.board}, not for the {board}")
    words = flash.command(board, port, image.path, verify=verify)
    if dry_run:
        click.echo(shlex.join(words))
        return
    try:
        flash.run(words)
        if verify:
            click.echo(f"{port}: the flash is as in {image.path}")
        if ask:
            _ask(image, PortOptions(port, baud, parity), unit)
    except (FlashError, BoardError) as error:
        click.echo(f"pixstep: {error}", err=True)
        ctx.exit(1)


def _ask(image: Image, options: PortOptions, unit: int) -> None:
    """Compare what the board says of itself with the image."""
    found = connection.open_port(options, lambda text: say((text,)))
    try:
        text = found.board(unit).identify().text
    finally:
        found.close()
    wanted = f"pixstep {image.board} {image.version}"
    if text != wanted:
        raise FlashError(f"{options.port}: the board says {text!r}, the image is {wanted!r}")
    click.echo(f"{options.port}: unit {unit} is {text}")


COMMANDS = (flash_command,)
