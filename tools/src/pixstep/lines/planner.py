# SPDX-License-Identifier: MIT
"""The edges that a board will make, planned by the firmware's own core: ticks and positions."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import count
from typing import TYPE_CHECKING

from pixstep.errors import RefusedError
from pixstep.lazy import lazy
from pixstep.lines import core, linecheck
from pixstep.lines.core import CoreLimits
from pixstep.lines.line import Line
from pixstep.lines.rational import refuse_period

if TYPE_CHECKING:
    import numpy as np
else:
    np = lazy("numpy")

EDGES, PIXELS = ("step", "tick"), ("pixel", "tick", "expected_steps")
_SHORTEST_TICKS = 64  # below this the core's ring cannot be filled in time on any board


class LineRefusedError(RefusedError):
    """The core refused the line; the message names the error, the pixel and why."""


@dataclass(frozen=True)
class Plan:
    """The planned rows under their heads, numbered from 1, and the warnings that the core gave."""

    heads: tuple[str, ...]
    values: array[int]  # of all rows in turn, without their numbers
    warnings: tuple[str, ...]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.values) // (len(self.heads) - 1)

    def columns(self) -> np.ndarray:
        """Return the rows as an int64 array."""
        values = np.array(self.values, dtype=np.int64).reshape(-1, len(self.heads) - 1)
        return np.column_stack((np.arange(1, len(values) + 1, dtype=np.int64), values))

    @cached_property
    def csv(self) -> str:
        """The rows as CSV text."""
        rows = (",".join(map(str, row)) for row in self._rows())
        return "\n".join((",".join(self.heads), *rows)) + "\n"

    def _rows(self) -> Iterator[tuple[int, ...]]:
        wide = len(self.heads) - 1
        columns = (self.values[first::wide] for first in range(wide))
        return zip(count(1), *columns, strict=False)


def plan(
    line: Line,
    hz: Fraction,
    *,
    tick_hz: int,
    pixels: bool = False,
    limits: CoreLimits | None = None,
) -> Plan:
    """Plan a line: the tick of each step, or with `pixels` ticks and positions of pixel edges.

    `tick_hz` are the timer ticks a second. Without `limits` the line may do what no board allows.

    Raises LineRefusedError if the core's line check refuses, UserError for a pixel frequency that
    no board can carry.
    """
    refuse_period(hz, tick_hz)
    limits = limits or loosest(hz, tick_hz)
    entries = linecheck.entries(line)
    found = core.check(entries, limits)
    for code in found:
        if code.is_error:
            raise LineRefusedError(f"{line.name}: line refused: {_text(code)}")
    values = core.plan(entries, hz, tick_hz, limits, pixels=pixels)
    return Plan(
        PIXELS if pixels else EDGES, values, tuple(f"warning: {_text(code)}" for code in found)
    )


def loosest(hz: Fraction, tick_hz: int) -> CoreLimits:
    """Return limits that let every line pass that the core can plan."""
    shortest = _SHORTEST_TICKS
    return CoreLimits(int(tick_hz / hz), shortest, shortest, shortest, 4 * shortest)


def _text(code: core.Code) -> str:
    return f"{code.name} at pixel {code.pixel}: {code.text}"
