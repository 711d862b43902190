# SPDX-License-Identifier: MIT
"""`pixstep flash`: firmware onto a board."""

import shlex
from pathlib import Path

import click

from pixstep.board import flash, link
from pixstep.board.boards import BOARD_NAMES
from pixstep.board.flash import FlashError, Image
from pixstep.board.port import Port
from pixstep.cli.board.group import port_options, unit_option
from pixstep.cli.command import FILE, command
from pixstep.cli.options import deliver_facts, json_option, say
from pixstep.errors import UserError


@command("flash")
@click.option("--board", type=click.Choice(BOARD_NAMES), required=True)
@port_options
@unit_option
@click.option("--hex", "hex_file", type=FILE, help="Image to write.  [default: the one built here]")
@click.option("--verify", is_flag=True, help="Only compare the board's flash with the image.")
@click.option("--dry-run", is_flag=True, help="Print avrdude's command line and do nothing.")
@json_option
@click.option(
    "--ask/--no-ask",
    default=True,
    show_default=True,
    help="Ask the board afterwards what it is.",
)
def flash_command(
    port: Port,
    unit: int,
    board: str,
    hex_file: Path | None,
    verify: bool,
    dry_run: bool,
    ask: bool,
    as_json: bool,
) -> None:
    """Write the firmware to a board by avrdude through its boot loader, then ask what it is.

    Builds nothing: tools/build does. Settings stored on the board stay: --unit, --baud and
    --parity are those that it is then asked with (the boot loader has its own), or --no-ask.
    docs/FLASHING.md has the rest.
    """
    image = flash.read_image(hex_file or flash.built_image(board))
    if image.board != board:
        raise UserError(f"{image.path}: an image for the {image.board}, not for the {board}")
    words = flash.command(board, port.name, image.path, verify=verify)
    facts = {"port": port.name, "board": board, "image": str(image.path), "avrdude": words}
    texts = []
    if dry_run:
        texts.append(shlex.join(words))
    else:
        port.require()
        flash.run(words)
        if verify:
            texts.append(f"{port.name}: the flash is as in {image.path}")
        if ask:
            texts.append(_ask(image, port, unit))
    if texts or as_json:
        deliver_facts({**facts, "done": not dry_run}, "\n".join(texts), as_json=as_json)


def _ask(image: Image, port: Port, unit: int) -> str:
    """Compare what the board says of itself with the image; return that in words."""
    found = link.open_port(port, lambda text: say((text,)))
    try:
        who = found.board(unit).who()
        text = f"pixstep {who.board} {who.firmware}"
    finally:
        found.close()
    wanted = f"pixstep {image.board} {image.version}"
    if text != wanted:
        raise FlashError(f"{port.name}: the board says {text!r}, the image is {wanted!r}")
    return f"{port.name}: unit {unit} is {text}"
