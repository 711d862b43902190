# SPDX-License-Identifier: MIT
"""The records of a flight as rows of documents, a row a pixel.

A board that cannot send the record of each pixel in time keeps every Nth, and each besides whose
position is not the expected one. In a row that has the record of one axis only, the others are
where they were expected to be: else they would have one too.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pixstep.api.records import AxisRecords
from pixstep.fly.places import Place
from pixstep.fly.scan_line import ScanLine
from pixstep.lazy import lazy

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Whole = npt.NDArray[np.int64]
else:
    np, npt = lazy("numpy"), lazy("numpy.typing")

DataKey = dict[str, Any]
Columns = dict[str, "npt.NDArray[Any]"]


@dataclass(frozen=True)
class Layout:
    """The data keys of a flyer's documents, each of which begins with the flyer's name."""

    name: str
    places: Sequence[Place]
    clock_errors: bool
    """True if the first board knows the errors of the clock's edges."""

    @property
    def scan(self) -> ScanLine | None:
        """The line whose points the pixels are counted by; None of lines that are no scan's."""
        return next((one.line for one in self.places if isinstance(one.line, ScanLine)), None)

    def key(self, *words: str) -> str:
        """Return a data key."""
        return "_".join((self.name, *words))

    def data_keys(self) -> dict[str, DataKey]:
        """Return all data keys as descriptors have them."""
        clock = f"pixstep:board{self.places[0].unit}/clock"
        found = {
            self.key("pixel"): _whole(clock, "px"),
            self.key("time"): number_key(clock, "s"),
        }
        if self.scan:
            found[self.key("point")] = _whole(f"scanspec:{self.scan.scan_axis}", "1")
        if self.clock_errors:
            found[self.key("clock_error")] = number_key(clock, "us")
        for place in self.places:
            source = place.source
            found[self.key(place.name, "expected")] = number_key(source, place.length_unit)
            found[self.key(place.name, "actual")] = number_key(source, place.length_unit)
            found[self.key(place.name, "deviation")] = _whole(source, "steps")
        return found


def _whole(source: str, unit: str) -> DataKey:
    return _data_key(source, "integer", "<i8", unit)


def number_key(source: str, unit: str) -> DataKey:
    """Return the data key of a number."""
    return _data_key(source, "number", "<f8", unit)


def _data_key(source: str, dtype: str, numpy_dtype: str, unit: str) -> DataKey:
    return {
        "source": source, "dtype": dtype, "dtype_numpy": numpy_dtype, "shape": [], "units": unit,
    }  # fmt: skip


class Rows:
    """The rows of one flight: given out once each, in the order of the pixels.

    `origins` is where the load of each place was at line zero, `tick_hz` the first board's ticks.
    """

    def __init__(self, layout: Layout, origins: Sequence[float], tick_hz: int) -> None:
        self._layout, self._origins, self._tick_hz = layout, origins, tick_hz
        self._expected = [place.expected_steps() for place in layout.places]
        self._lengths = [place.line.pixels for place in layout.places]
        self._last = 0  # pixel of the newest row that was given out

    def take(self, records: Sequence[AxisRecords]) -> Columns | None:
        """Return the columns of the rows that are complete and new, without times; None of none.

        A line that has ended stays at its end.
        """
        found = [self._of(place, records) for place in self._layout.places]
        known = [one for one in found if one is not None]
        if len(known) < len(found):
            return None
        pixels = self._complete(known)
        if not len(pixels):
            return None
        self._last = int(pixels[-1])
        return self._columns(pixels, known)

    def _of(self, place: Place, records: Sequence[AxisRecords]) -> AxisRecords | None:
        """Return the records of a place, if it has any yet."""
        for one in records:
            if (one.unit, one.axis) == (place.unit, place.axis) and len(one):
                return one
        return None

    def _complete(self, records: Sequence[AxisRecords]) -> Whole:
        """Return the new pixels that are known of all axes."""
        ends = [
            int(one.pixel[-1])
            for one, length in zip(records, self._lengths, strict=True)
            if int(one.pixel[-1]) < length
        ]
        last = min(ends, default=max(self._lengths))
        known = [one.pixel.astype(np.int64) for one in records]
        if any(one.missed for one in records):  # what is not recorded is not known
            pixels = functools.reduce(np.intersect1d, map(self._with_rest, known, self._lengths))
        else:
            pixels = functools.reduce(np.union1d, known)
        return pixels[(pixels > self._last) & (pixels <= last)]

    def _with_rest(self, pixels: Whole, length: int) -> Whole:
        """Return the pixels of records and those behind the end of their line."""
        return np.concatenate([pixels, np.arange(length + 1, max(self._lengths) + 1)])

    def _columns(self, pixels: Whole, records: Sequence[AxisRecords]) -> Columns:
        layout = self._layout
        columns: Columns = {layout.key("pixel"): pixels}
        if layout.scan:
            columns[layout.key("point")] = layout.scan.points_of(pixels)
        if layout.clock_errors:
            ticks = _held(pixels, records[0].pixel, records[0].edge_error_ticks)
            columns[layout.key("clock_error")] = ticks * (1e6 / self._tick_hz)
        for place, one, origin, line in zip(
            layout.places, records, self._origins, self._expected, strict=True
        ):
            expected, actual = _positions(pixels, one, line)
            columns[layout.key(place.name, "expected")] = place.positions(expected, origin)
            columns[layout.key(place.name, "actual")] = place.positions(actual, origin)
            columns[layout.key(place.name, "deviation")] = actual - expected
        return columns


def _positions(pixels: Whole, records: AxisRecords, line: Whole) -> tuple[Whole, Whole]:
    """Return where an axis was expected and where it was behind some pixels, steps."""
    expected = line[np.minimum(pixels, len(line) - 1)]
    actual = expected.copy()
    found = np.searchsorted(records.pixel, pixels)
    found[found == len(records)] = 0
    recorded = records.pixel[found] == pixels
    expected[recorded] = records.expected_steps[found[recorded]]
    actual[recorded] = records.actual_steps[found[recorded]]
    ended = pixels > len(line) - 1
    if ended.any():  # it rests where its last record has it
        actual[ended] = records.actual_steps[-1]
    return expected, actual


def _held(pixels: Whole, known: npt.NDArray[Any], values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the value of each pixel, or the newest one before it that is known."""
    found = np.searchsorted(known, pixels, side="right") - 1
    return np.where(found < 0, 0, values[np.maximum(found, 0)])
