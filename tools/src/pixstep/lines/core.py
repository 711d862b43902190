# SPDX-License-Identifier: MIT
"""The firmware's motion core, bound into Python: its line check, and the edges that it plans."""

from __future__ import annotations

import importlib.machinery
import importlib.util
import sys
from array import array
from collections.abc import Iterable
from dataclasses import astuple, dataclass
from fractions import Fraction
from functools import cache, cached_property
from itertools import count
from types import ModuleType
from typing import Any

from pixstep import natives
from pixstep.errors import RefusedError, UserError
from pixstep.lazy import np
from pixstep.lines.line import Line
from pixstep.lines.runs import MAX_WORD, safe_entries
from pixstep.lines.units import refuse_period

EDGES, PIXELS = ("step", "tick"), ("pixel", "tick", "expected_steps")
FIRST_WARNING = 32  # codes from here on are warnings: the line is taken
LIBRARY = "_core.pyd" if sys.platform == "win32" else "_core.abi3.so"
NO_LIMIT = 0xFFFFFFFF  # ticks of a pixel
_SHORTEST_TICKS = 64  # below this the core's ring cannot be filled in time on any board
_VALUES = 1 << 16  # planned at once
_MOST_OF_ENTRY = 7  # findings: four limits, an oscillation, another error, a warning

Entry = tuple[int, int]


@dataclass(frozen=True)
class CoreLimits:
    """What a board allows, in the form and order of the firmware's struct line_limits.

    Intervals and times are in timer ticks, the acceleration in steps/pixel2, the start/stop speed
    in steps/pixel. What is left out is no limit; the core takes what it cannot hold as the most
    that it can.
    """

    pixel_ticks: int = NO_LIMIT
    min_interval_ticks: int = 0
    smooth_min_interval_ticks: int = 0
    seek_min_interval_ticks: int = 0
    reversal_min_ticks: int = 0
    max_acceleration: int = 0
    start_stop_steps: int = 0


@dataclass(frozen=True)
class CoreFinding:
    """What the core found: its name, the board's words for it, and its 1-based pixel.

    The pixel of what is wrong with the end of a line is the one behind the last.
    """

    name: str
    text: str
    pixel: int
    is_error: bool


def check(entries: Iterable[Entry], limits: CoreLimits) -> list[CoreFinding]:
    """Check a line as a board does; the first error is the one that the board gives."""
    return Checker(limits).more(entries)


class Checker:
    """A check of a line that comes in parts: memory does not grow with the line."""

    def __init__(self, limits: CoreLimits) -> None:
        ffi, lib = extension().ffi, extension().lib
        begun = lib.checker_begin(_limits(limits))
        if not begun:
            raise MemoryError
        self._checker = ffi.gc(begun, lib.checker_end)

    def more(self, entries: Iterable[Entry]) -> list[CoreFinding]:
        """Return what is found in the entries that follow."""
        ffi, lib = extension().ffi, extension().lib
        rows = _words(entries)
        room = _MOST_OF_ENTRY * len(rows)
        found = ffi.new("struct core_finding[]", max(room, 1))
        segments = ffi.new("struct segment[]", rows)
        count = lib.checker_more(self._checker, segments, len(rows), found, room)
        rows_of, read = codes(), [(found[k].code, found[k].pixel) for k in range(count)]
        return [
            CoreFinding(
                rows_of[number]["name"], rows_of[number]["text"], pixel, number < FIRST_WARNING
            )
            for number, pixel in read
        ]


def _planned_rows(
    entries: list[Entry], hz: Fraction, tick_hz: int, limits: CoreLimits, *, pixels: bool
) -> array[int]:
    """Return the values of `plan`; the line is one that `check` passes."""
    ffi, lib = extension().ffi, extension().lib
    rows = _words(entries)
    segments = ffi.new("struct segment[]", rows)  # kept until the plan ends
    begun = lib.plan_begin(
        tick_hz, hz.numerator, hz.denominator, _limits(limits), segments, len(rows), pixels
    )
    if not begun:
        raise MemoryError
    made = ffi.gc(begun, lib.plan_end)
    found, values = array("q"), array("q", bytes(8 * _VALUES))
    while not lib.plan_over(made):  # a call is short: signals are heeded between two
        count = lib.plan_rows(made, ffi.from_buffer("int64_t[]", values), _VALUES)
        if count < 0:
            raise RuntimeError("the firmware's core broke a promise of its own: please report it")
        found.extend(values[:count])
    return found


def _words(entries: Iterable[Entry]) -> list[Entry]:
    """Return entries with the words of marks and parameters as the signed counts they are."""
    return [((count + 0x8000 & 0xFFFF) - 0x8000, repeat) for count, repeat in entries]


def _limits(limits: CoreLimits) -> Any:  # of cffi, which has no types
    ticks, *words = astuple(limits)
    held = min(ticks, NO_LIMIT), *(min(word, MAX_WORD) for word in words)
    return extension().ffi.new("struct line_limits *", held)


@cache
def codes() -> dict[int, dict[str, Any]]:
    """Return the rows of the firmware's table of line errors by number."""
    return {row["code"]: row for row in natives.tables()["line_errors"]}


@cache
def extension() -> ModuleType:
    """Load the extension: the firmware's core, and the inner loops of programs."""
    path = natives.made(LIBRARY)
    loader = importlib.machinery.ExtensionFileLoader("_core", str(path))
    spec = importlib.util.spec_from_loader("_core", loader)
    assert spec is not None  # there is a loader
    try:
        module = importlib.util.module_from_spec(spec)
        loader.exec_module(module)
    except ImportError as error:
        raise UserError(f"{path}: {error}") from None
    return module


class LineRefusedByCoreError(RefusedError):
    """The core refused the line; the message names the error, the pixel and why."""


@dataclass(frozen=True)
class EdgePlan:
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
        wide = len(self.heads) - 1
        columns = (self.values[first::wide] for first in range(wide))
        rows = (",".join(map(str, row)) for row in zip(count(1), *columns, strict=False))
        return "\n".join((",".join(self.heads), *rows)) + "\n"


def plan(
    line: Line,
    hz: Fraction,
    *,
    tick_hz: int,
    pixels: bool = False,
    limits: CoreLimits | None = None,
) -> EdgePlan:
    """Plan a line: the tick of each step, or with `pixels` ticks and positions of pixel edges.

    `tick_hz` are the timer ticks a second. Without `limits` the line may do what no board allows.

    Raises LineRefusedByCoreError if the core's line check refuses, UserError for a pixel frequency
    that no board can carry.
    """
    refuse_period(hz, tick_hz)
    limits = limits or loosest(hz, tick_hz)
    entries = safe_entries(line)
    found = check(entries, limits)
    for code in found:
        if code.is_error:
            raise LineRefusedByCoreError(f"{line.name}: line refused: {_text(code)}")
    values = _planned_rows(entries, hz, tick_hz, limits, pixels=pixels)
    return EdgePlan(
        PIXELS if pixels else EDGES, values, tuple(f"warning: {_text(code)}" for code in found)
    )


def loosest(hz: Fraction, tick_hz: int) -> CoreLimits:
    """Return limits that let every line pass that the core can plan."""
    shortest = _SHORTEST_TICKS
    return CoreLimits(int(tick_hz / hz), shortest, shortest, shortest, 4 * shortest)


def _text(code: CoreFinding) -> str:
    return f"{code.name} at pixel {code.pixel}: {code.text}"
