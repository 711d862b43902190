# SPDX-License-Identifier: MIT
"""Put a measured value into a machine file: comments, order and everything else stay."""

from pathlib import Path

from pixstep import atomic, tomltext
from pixstep.errors import UserError
from pixstep.machine.reading import Machine


def set_backlash(path: Path, motor: str, steps: int) -> None:
    """Write the play of a motor, in steps, into a machine file.

    Raises UserError naming the mistake for a file that is wrong before.
    """
    Machine.load(path)[motor]  # names the mistake of a wrong file, and a motor that is not there
    text, _ = tomltext.read(path)
    import tomlkit  # takes long to load

    document = tomlkit.parse(text)
    try:
        document["motors"][motor]["backlash"] = f"{steps} steps"
    except (KeyError, TypeError):
        raise UserError(f"{path}: motors.{motor} is not a table of its own") from None
    with atomic.rules(atomic.Rules(force=True)):
        atomic.write_text(path, document.as_string())
