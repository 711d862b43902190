# SPDX-License-Identifier: MIT
"""What equal means: commands by name, order and argument, fields by ten significant digits."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

from pixstep.motor_record import MotorCommand

TOLERANCE: Final = 1e-9


@dataclass(frozen=True)
class Difference:
    """The first thing in a trace that is not as recorded."""

    step: int
    """Number of the step, from 0; -1: before the first."""
    operation: Sequence[Any]
    what: str
    """A field, "commands", "dmov", "ticks" or "settled"."""
    wanted: Any
    found: Any

    def __str__(self) -> str:
        return (
            f"step {self.step} {json.dumps(list(self.operation))}: {self.what}:"
            f" wanted {json.dumps(self.wanted)}, found {json.dumps(self.found)}"
        )


def same_commands(wanted: Sequence[str], found: Sequence[MotorCommand]) -> bool:
    """True if commands are equal in name, order and argument."""
    return len(wanted) == len(found) and all(map(_same_command, wanted, found))


def _same_command(wanted: str, found: MotorCommand) -> bool:
    name, _, argument = wanted.partition(" ")
    if name != found.verb or bool(argument) != (found.argument is not None):
        return False
    return found.argument is None or close(float(argument), found.argument)


def close(wanted: float, found: float) -> bool:
    """True if two numbers are equal, as far as ten significant digits tell."""
    return abs(wanted - found) <= TOLERANCE * max(1.0, abs(wanted))


def changes(before: int, posts: Sequence[float]) -> list[int]:
    """Return the changes of a flag: two equal posts that follow each other are one state."""
    states = [before]
    for post in posts:
        if int(post) != states[-1]:
            states.append(int(post))
    return states[1:]
