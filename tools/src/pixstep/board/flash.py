# SPDX-License-Identifier: MIT
"""Firmware onto a board by avrdude through its boot loader; nothing else is written."""

import re
import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from pixstep import natives
from pixstep.board import boards
from pixstep.errors import PlainError, UserError

# Avrdude without a board goes on for minutes, at full load. A boot loader answers within two
# seconds of the reset; writing and verifying a full Mega takes a third of LIMIT_S.
ANSWER_LIMIT_S = 8.0
LIMIT_S = 60.0
_IDENTITY = re.compile(rb"pixstep (\w+) (\d+\.\d+)")
_DATA = 0


@dataclass(frozen=True)
class FirmwareImage:
    """An Intel HEX file, the board and the version that it says it is for."""

    path: Path
    board: str
    version: str


def built_image(board: str) -> Path:
    """Return the image that the build leaves for a board, or the wheel brought."""
    return natives.hex_image(board)


def read_image(path: Path) -> FirmwareImage:
    """Read an image and find what it says of itself; raises UserError if it is no pixstep image."""
    try:
        lines = path.read_text(encoding="ascii").split()
    except UnicodeDecodeError:
        raise UserError(f"{path}: not an Intel HEX file") from None
    except FileNotFoundError:
        raise UserError(
            f"{path}: missing: build it with `tools/build`, or name another with --hex"
        ) from None
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    found = _IDENTITY.search(b"".join(_data(path, number, row) for number, row in _rows(lines)))
    if not found:
        raise UserError(f"{path}: not a pixstep image: it names no board and version")
    board, version = (part.decode("ascii") for part in found.groups())
    return FirmwareImage(path, board, version)


def command(board: str, port: str, image: Path, *, verify: bool = False) -> list[str]:
    """Return the command line of avrdude: write and verify, or with `verify` only compare.

    -D: the chip is not erased as a whole, the boot loader writes page by page.
    """
    loader = boards.load(board).programmer
    mode = "v" if verify else "w"
    return [
        "avrdude", "-p", loader.part, "-c", loader.protocol, "-b", str(loader.baud),
        "-P", port, "-D", "-U", f"flash:{mode}:{image}:i",
    ]  # fmt: skip


def run(words: list[str]) -> None:
    """Run avrdude with its own output on the terminal; raises UserError if it is not there.

    Raises FlashError if no boot loader answers, or it fails, or is not done in time: it is ended
    then.
    """
    program = shutil.which(words[0])
    if program is None:
        raise UserError(
            "avrdude is missing: apt-get install avrdude (in a clone tools/setup does so)"
        )
    _find_loader([program, *words[1 : words.index("-U")]])
    try:
        status = subprocess.run([program, *words[1:]], check=False, timeout=LIMIT_S).returncode
    except subprocess.TimeoutExpired:
        raise FlashError(
            f"avrdude is not done in {LIMIT_S:g} s and was ended: is there a board on this port, "
            f"is it the board named, does opening the port reset it?"
        ) from None
    if status:
        raise FlashError(
            f"avrdude failed (exit status {status}): is this the board's port, is another program "
            f"using it, is it the board named?"
        )


def _find_loader(words: list[str]) -> None:
    """Let avrdude read the part's signature and nothing else: it does so at once or never."""
    try:
        done = subprocess.run(
            words, check=False, timeout=ANSWER_LIMIT_S, capture_output=True, text=True
        )
    except subprocess.TimeoutExpired:
        raise FlashError(
            f"no boot loader answers in {ANSWER_LIMIT_S:g} s, nothing was written: is there a "
            f"board on this port, is it the board named, does opening the port reset it?"
        ) from None
    if done.returncode:
        said = [row.strip() for row in done.stderr.splitlines() if "rror" in row]
        raise FlashError(
            f"avrdude finds no boot loader (exit status {done.returncode}"
            f"{': ' + said[0] if said else ''}), nothing was written: is this the board's port, "
            f"is another program using it, is it the board named?"
        )


class FlashError(PlainError):
    """The board was not flashed, or does not say so afterwards."""


def _rows(lines: list[str]) -> Iterable[tuple[int, str]]:
    return enumerate(lines, 1)


def _data(path: Path, number: int, row: str) -> bytes:
    """Return the data bytes of a row of Intel HEX, none if it is a row of another kind."""
    try:
        content = bytes.fromhex(row[1:])
    except ValueError:
        content = b""
    if row[:1] != ":" or len(content) < 5 or len(content) != content[0] + 5 or sum(content) % 256:
        raise UserError(f"{path}:{number}: not a row of an Intel HEX file")
    return content[4:-1] if content[3] == _DATA else b""
