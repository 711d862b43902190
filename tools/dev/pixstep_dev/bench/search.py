# SPDX-License-Identifier: MIT
"""The highest clean count of a family of lines: bisect short lines, confirm with long ones.

A rate is clean when its line, after its own ramp, gives the exact edges for LONG_S seconds and no
fault. Below the result some rates are tested too: a hole there is reported, and the search goes on
below it, so that every tested rate up to the result is clean.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from pixstep_dev.bench.trial import CLEAN, WRONG, BenchTrial

SHORT_S = 0.3
LONG_S = 2.0
CONFIRMED = (0.5, 0.75, 0.9, 0.95)  # of the result

Attempt = Callable[[int, float], BenchTrial]  # a count at a line's peak, seconds there


@dataclass
class Found:
    """The result: highest clean count (0: none), how the next one ended, and what was tested."""

    count: int = 0
    beyond: BenchTrial | None = None
    confirmed: list[int] = field(default_factory=list)
    holes: dict[int, BenchTrial] = field(default_factory=dict)
    wrong: dict[int, BenchTrial] = field(default_factory=dict)


class Search:
    """A search over the multiples of `unit` up to `top`; `shift(n)` may move a confirmed count."""

    def __init__(
        self, attempt: Attempt, unit: int, top: int, shift: Callable[[int], int] = lambda n: n
    ) -> None:
        self._attempt, self._unit, self._top, self._shift = attempt, unit, top, shift
        self._known: dict[tuple[int, float], BenchTrial] = {}
        self._found = Found()

    def go(self) -> Found:
        """Search; return what was found."""
        found, high = self._found, self._top // self._unit + 1
        while True:
            low = self._bisect(0, high, SHORT_S)
            low = self._down_to_clean(low)
            hole = self._confirm(low)
            if hole is None:
                break
            high = -(-hole // self._unit)
        found.count = low * self._unit
        if (low + 1) * self._unit <= self._top:
            found.beyond = self._try((low + 1) * self._unit, LONG_S)
        return found

    def _try(self, count: int, seconds: float) -> BenchTrial:
        """Run a count once and remember how it ended."""
        if (count, seconds) not in self._known:
            trial = self._attempt(count, seconds)
            self._known[count, seconds] = trial
            if trial.kind == WRONG:
                self._found.wrong[count] = trial
        return self._known[count, seconds]

    def _clean(self, units: int, seconds: float) -> bool:
        return units == 0 or self._try(units * self._unit, seconds).kind == CLEAN

    def _bisect(self, low: int, high: int, seconds: float) -> int:
        """Return the last clean multiple between `low`, clean, and `high`, not."""
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self._clean(middle, seconds) else (low, middle)
        return low

    def _down_to_clean(self, low: int) -> int:
        """Return the highest multiple at or below `low` that is clean for the long time."""
        bad, stride = None, 1
        while not self._clean(low, LONG_S):
            bad, low, stride = low, max(0, low - stride), 2 * stride
        return low if bad is None else self._bisect(low, bad, LONG_S)

    def _confirm(self, low: int) -> int | None:
        """Test counts below the result; return the lowest that is not clean."""
        if low == 0:
            return None
        units = {max(1, int(part * low)) for part in CONFIRMED}
        counts = sorted({max(2, self._shift(one * self._unit)) for one in units})
        for count in counts:
            trial = self._try(count, LONG_S)
            if trial.kind != CLEAN:
                self._found.holes[count] = trial
                return count
        self._found.confirmed = counts
        return None


def under_load(
    clean: int, parts: Sequence[float], unit: int, attempt: Callable[[int], BenchTrial]
) -> int:
    """Return the first part of a clean count that is clean under a saturated serial line too.

    `attempt` runs a count under that load, a multiple of `unit`. 0: none of the parts is clean.
    """
    for part in parts if clean else ():
        some = int(part * clean) // unit * unit
        if attempt(some).kind == CLEAN:
            return some
    return 0


def texts(place: str, unit: str, trials: dict[int, BenchTrial]) -> list[str]:
    """Return how some counts of a search ended, each with its place and unit."""
    return [f"{place}, {count} {unit}: {trial.text}" for count, trial in trials.items()]


def holes(row: dict[str, Any]) -> str:
    """Return the holes of a search's row for its table."""
    return "; ".join(row["holes"]) or "none"
