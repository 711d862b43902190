# SPDX-License-Identifier: MIT
"""Firmware onto a board."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TypedDict

from pixstep.board import flash
from pixstep.board.flash import FlashError, Image
from pixstep.errors import UserError
from pixstep.operations import bus, shared
from pixstep.operations.bus import ToBoard
from pixstep.operations.desk import Desk
from pixstep.operations.kinds import FILE
from pixstep.operations.request import flag, operation, option
from pixstep.operations.result import Result


class FlashedBoard(TypedDict):
    """The image, the command line of avrdude, and whether it was run."""

    port: str
    board: str
    image: str
    avrdude: list[str]
    done: bool


@operation("flash")
class Flash(ToBoard):
    """Write the firmware to a board by avrdude through its boot loader, then ask what it is.

    Builds nothing: tools/build does. Settings stored on the board stay: --unit, --baud and
    --parity are those that it is then asked with (the boot loader has its own), or --no-ask.
    docs/FLASHING.md has the rest.
    """

    result = FlashedBoard

    board: str = shared.simulated_board()
    hex_file: Path | None = option(
        FILE, "Image to write.", "--hex", default_text="the one built here"
    )
    verify: bool = flag("Only compare the board's flash with the image.")
    dry_run: bool = flag("Print avrdude's command line and do nothing.")
    ask: bool = flag("Ask the board afterwards what it is.", off="--no-ask", default=True)

    def run(self, desk: Desk) -> Result:
        """Run avrdude, then ask the board."""
        image = flash.read_image(self.hex_file or flash.built_image(self.board))
        if image.board != self.board:
            raise UserError(
                f"{image.path}: an image for the {image.board}, not for the {self.board}"
            )
        words = flash.command(self.board, self.port, image.path, verify=self.verify)
        texts = []
        if self.dry_run:
            texts.append(shlex.join(words))
        else:
            self.bus.require()
            flash.run(words)
            if self.verify:
                texts.append(f"{self.port}: the flash is as in {image.path}")
            if self.ask:
                texts.append(self._asked(desk, image))
        data: FlashedBoard = {
            "port": self.port, "board": self.board, "image": str(image.path), "avrdude": words,
            "done": not self.dry_run,
        }  # fmt: skip
        return Result(data, "\n".join(texts))

    def _asked(self, desk: Desk, image: Image) -> str:
        """Compare what the board says of itself with the image; return that in words."""
        with bus.opened(desk, self) as found:
            who = found.board(self.unit).who()
        text, wanted = (
            f"pixstep {who.board} {who.firmware}",
            f"pixstep {image.board} {image.version}",
        )
        if text != wanted:
            raise FlashError(f"{self.port}: the board says {text!r}, the image is {wanted!r}")
        return f"{self.port}: unit {self.unit} is {text}"
