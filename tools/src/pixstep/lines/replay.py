# SPDX-License-Identifier: MIT
"""Whether a board can follow lines that run together: its main loop replayed by the C core."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from pixstep.lines import runs
from pixstep.lines.core import extension
from pixstep.lines.line import Line


@dataclass(frozen=True)
class Loop:
    """A board's main loop and what surrounds it: struct guarantee_board of the C core."""

    axes: int
    short_curves: bool
    pixel_ticks: float
    divider: int = 1
    lead_edges: int = 0
    more_edges: int = 0
    bytes_per_tick: float = 0.0
    asked_per_tick: float = 0.0
    round_ticks: float = 0.0
    spare_ticks: float = 0.0
    margin: float = 1.0
    most_calls: int = 0


@dataclass(frozen=True)
class ReplayVerdict:
    """How a replay ended: the first place that is late, or the least time to spare in ticks."""

    follows: bool
    axis: int  # a place in the sequence of lines
    pixel: int
    late_ticks: float
    slack_ticks: float
    busy: float


class Replay:
    """Lines that run together, ready to be replayed with any costs and any loop."""

    def __init__(self, lines: Sequence[Line]) -> None:
        ffi = extension().ffi
        self._kept = [ffi.new("struct segment[]", _segments(line)) for line in lines]
        self._axes = ffi.new("struct guarantee_axis[]", len(lines))
        for axis, kept, line in zip(self._axes, self._kept, lines, strict=True):
            axis.entries, axis.count, axis.smooth = kept, len(kept), line.smooth
            if line.shifted_pixels:
                axis.backlash_steps, axis.line_speed = line.backlash, line.line_speed

    def judge(self, costs: Mapping[str, float], loop: Loop) -> ReplayVerdict:
        """Replay the lines."""
        ffi, lib = extension().ffi, extension().lib
        found = ffi.new("struct guarantee_verdict *")
        lib.guarantee_judge(_costs(costs), _loop(loop), self._axes, len(self._kept), found)
        return ReplayVerdict(
            found.follows,
            found.axis,
            found.pixel,
            found.late_ticks,
            found.slack_ticks,
            found.busy,
        )

    def demand(self, costs: Mapping[str, float], loop: Loop) -> tuple[float, float]:
        """Return the cycles of decoding the first line, and of accounting for it without looks."""
        ffi, lib = extension().ffi, extension().lib
        sums = ffi.new("double[2]")
        lib.guarantee_demand(_costs(costs), _loop(loop), self._axes, sums, sums + 1)
        return sums[0], sums[1]


def _segments(line: Line) -> list[tuple[int, int]]:
    return runs.encode(line.counts)


def _costs(costs: Mapping[str, float]) -> Any:  # of cffi, which has no types
    return extension().ffi.new("struct guarantee_costs *", dict(costs))


def _loop(loop: Loop) -> Any:
    return extension().ffi.new("struct guarantee_board *", asdict(loop))
