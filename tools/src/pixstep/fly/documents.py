# SPDX-License-Identifier: MIT
"""The records of a flight as rows of documents, a row a pixel, and what their columns are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pixstep.api.motion import AxisRecords
from pixstep.fly.scan_line import ScanLine
from pixstep.fly.tracks import FlightTrack, FlownAxis
from pixstep.lazy import np, npt

if TYPE_CHECKING:
    Whole = npt.NDArray[np.int64]

DataKey = dict[str, Any]
Columns = dict[str, "npt.NDArray[Any]"]


@dataclass(frozen=True)
class DocumentLayout:
    """The data keys of a flyer's documents, each of which begins with the flyer's name."""

    name: str
    places: Sequence[FlownAxis]
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
            self.key("records"): _whole(clock, "1"),
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


class FlightRows:
    """The rows of one flight: given out once each, in the order of the pixels.

    Each pixel has a row whose position is known of all axes (tracks.py); `records` is how many of
    them have a record of their own.
    `tracks` are the axes', in the order of the layout's places; `tick_hz` the first board's ticks.
    """

    def __init__(self, layout: DocumentLayout, tracks: Sequence[FlightTrack], tick_hz: int) -> None:
        self._layout, self._tracks, self._tick_hz = layout, tracks, tick_hz
        self._length = max(track.length for track in tracks)
        self._last = 0  # pixel of the newest row that was given out

    def take(self, records: Sequence[AxisRecords], *, over: bool, ended: bool) -> Columns | None:
        """Return the columns of the rows that are complete and new, without times; None of none.

        `over` says that no more records come, `ended` that all lines have come to their end.
        """
        found = [one for track in self._tracks if (one := track.of(records)) is not None]
        if len(found) < len(self._tracks):
            return None
        for track, one in zip(self._tracks, found, strict=True):
            if not track.learn(one, over=over):
                return None
        last = self._length if ended else self._reached(found)
        pixels = np.arange(self._last + 1, last + 1)
        known = [track.knows(pixels, one) for track, one in zip(self._tracks, found, strict=True)]
        pixels = pixels[np.logical_and.reduce(known)]
        self._last = max(self._last, last)
        return self._columns(pixels, found) if len(pixels) else None

    def _reached(self, records: Sequence[AxisRecords]) -> int:
        """Return the last pixel up to which all axes are known; those that have ended stay."""
        found = [track.reached(one) for track, one in zip(self._tracks, records, strict=True)]
        return min(self._length, *found)

    def _columns(self, pixels: Whole, records: Sequence[AxisRecords]) -> Columns:
        layout = self._layout
        recorded = [np.isin(pixels, one.pixel) for one in records]
        columns: Columns = {
            layout.key("pixel"): pixels, layout.key("records"): np.sum(recorded, axis=0),
        }  # fmt: skip
        if layout.scan:
            columns[layout.key("point")] = layout.scan.points_of(pixels)
        if layout.clock_errors:
            ticks = _held(pixels, records[0].pixel, records[0].edge_error_ticks)
            columns[layout.key("clock_error")] = ticks * (1e6 / self._tick_hz)
        for track, one in zip(self._tracks, records, strict=True):
            name = track.place.name
            expected, actual = track.steps(pixels, one)
            columns[layout.key(name, "expected")] = track.positions(expected)
            columns[layout.key(name, "actual")] = track.positions(actual)
            columns[layout.key(name, "deviation")] = actual - expected
        return columns


def _held(pixels: Whole, known: npt.NDArray[Any], values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the value of each pixel, or the newest one before it that is known."""
    found = np.searchsorted(known, pixels, side="right") - 1
    return np.where(found < 0, 0, values[np.maximum(found, 0)])
