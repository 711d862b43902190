# SPDX-License-Identifier: MIT
"""The native build of the firmware's own core: planned ticks and expected positions."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from pixstep import natives
from pixstep.errors import RefusedError, UserError
from pixstep.lines import runs
from pixstep.lines.line import Line
from pixstep.lines.rational import hz_text

_REFUSED = "line refused:"


class LineRefusedError(RefusedError):
    """The core refused the line; the message names the error, the pixel and why."""


@dataclass(frozen=True)
class Plan:
    """Output of pixstep-plan as text, and the warnings it gave."""

    csv: str
    warnings: tuple[str, ...]

    def columns(self) -> np.ndarray:
        """Return the rows as an int64 array without the header."""
        body = self.csv.split("\n", 1)[1]
        values = np.array(body.replace(",", " ").split(), dtype=np.int64)
        width = self.csv.split("\n", 1)[0].count(",") + 1
        return values.reshape(-1, width)


def plan(line: Line, hz: Fraction, *, tick_hz: int, pixels: bool = False) -> Plan:
    """Run pixstep-plan on a line: CSV `step,tick`, or `pixel,tick,expected_steps`.

    `tick_hz` are the timer ticks a second.

    Raises LineRefusedError if the core's line check refuses, UserError if it cannot run.
    """
    speed = line.line_speed if line.backlash else 0
    arguments = [natives.program("pixstep-plan"), "--hz", hz_text(hz)]
    arguments += ["--timer-hz", tick_hz, "--decode", line.decode]
    arguments += ["--backlash", line.backlash, "--line-speed", speed]
    arguments += ["--negative"] if line.negative else []
    arguments += ["--pixels"] if pixels else []
    entries = "".join(f"{count} {repeat}\n" for count, repeat in runs.encode(line.counts))
    done = natives.run(arguments, stdin=entries)
    messages = done.stderr.strip().splitlines()
    if messages and messages[-1].startswith(_REFUSED):
        raise LineRefusedError(f"{line.name}: {messages[-1]}")
    if done.returncode:
        text = messages[-1] if messages else f"exit status {done.returncode}"
        raise UserError(f"pixstep-plan: {text}")
    return Plan(done.stdout, tuple(messages))
