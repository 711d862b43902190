# SPDX-License-Identifier: MIT
"""What an axis has done while it was watched: its speed, and where it was in its line."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

_LOOKS = 2  # over which a speed is taken
_KEPT = 600  # speeds; at four a second those of two minutes and a half
_MOST = 1200  # places of a line: of a longer one every second place is let go, again and again


class Trail:
    """The speeds of an axis, and its places in the newest line that it was seen in.

    `line` counts the lines that were seen: with another number the places begin again.
    """

    def __init__(self) -> None:
        self.line = 0
        self.speed: float | None = None  # steps a second
        self._speeds: deque[tuple[float, float]] = deque(maxlen=_KEPT)
        self._places: list[tuple[int, int]] = []  # pixel and position
        self._last: deque[tuple[float, Mapping[str, int]]] = deque(maxlen=_LOOKS)

    def add(self, time_s: float, axis: Mapping[str, int]) -> None:
        """Add the registers of the axis as they were at a time."""
        pixel, position = axis["pixel"], axis["position_steps"]
        if not self._last:
            self._begin()
        else:
            before = self._last[-1][1]
            if pixel < before["pixel"] or axis["lines_done"] < before["lines_done"]:
                self._begin()
            first_s, first = self._last[0]
            if time_s > first_s:
                self.speed = (position - first["position_steps"]) / (time_s - first_s)
                self._speeds.append((round(time_s, 3), round(self.speed, 2)))
        if not self._places or self._places[-1] != (pixel, position):
            self._places.append((pixel, position))
        if len(self._places) > _MOST:
            del self._places[1:-1:2]
        self._last.append((time_s, axis))

    def lose(self) -> None:
        """Forget how it was last: a board that comes back may have been reset."""
        self.speed = None
        self._last.clear()

    def as_json(self) -> dict[str, Any]:
        """Return all that was seen, as plain data."""
        return {"line": self.line, "places": self._places[:], "speeds": list(self._speeds)}

    def _begin(self) -> None:
        self.line += 1
        self._places.clear()
