# SPDX-License-Identifier: MIT
"""An encoder at the load, read by a program of the user's."""

import math
import shlex
import subprocess
from collections.abc import Callable

from pixstep.errors import UserError

Encoder = Callable[[], float]
_TIMEOUT_S = 10.0


def of_command(text: str) -> Encoder:
    """Return what runs a command and takes the number that it prints: the load's position, steps.

    Raises UserError for a text that is no command; so does a call if the command fails, takes more
    than 10 s, or prints something else.
    """
    try:
        words = shlex.split(text)
    except ValueError as error:
        raise UserError(f"encoder {text!r}: {error}") from None
    if not words:
        raise UserError(f"encoder {text!r}: expected a command")

    def read() -> float:
        try:
            done = subprocess.run(
                words, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False
            )
        except (OSError, subprocess.TimeoutExpired, UnicodeDecodeError) as error:
            raise UserError(f"encoder {text!r}: {error}") from None
        if done.returncode:
            raise UserError(f"encoder {text!r}: ended with status {done.returncode}")
        try:
            value = float(done.stdout)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise UserError(f"encoder {text!r}: printed {done.stdout[:40]!r}, expected a number")
        return value

    return read
