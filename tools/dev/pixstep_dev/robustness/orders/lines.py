# SPDX-License-Identifier: MIT
"""Random lines of a wanted speed, from one step a second to the fastest that a board can make."""

import random
from dataclasses import dataclass

from pixstep.board import boards
from pixstep.lines.runs import MARK_END, MARK_NEGATIVE, MARK_SMOOTH, MARK_START, MARK_WAIT_FOR_EDGE
from pixstep_dev.robustness.estops import steady_smooth_ticks
from pixstep_dev.robustness.orders.actions import Entries

FASTEST = 60_000  # steps/s
_REVERSAL_TICKS = 5000  # above what any board needs to turn round
_PIXEL_HZ = (1, 3, 10, 30, 100, 300)
_SLOWEST_CLOCK_HZ = 30
_LONGEST_PERIOD_TICKS = 0xFFFFFF  # of a pixel, on every board
_PIXELS_S = 400  # of all axes together; several may ask for more than the board can decode
_LASTS_S = 2
_PLACE_TICKS = 81_920  # of firmware/app/axes/reference.c
_GO_S = 0.02  # from a look at the newest edge until `go` has been carried out
_SPARSE = 6  # pairs of a single step and a rest


@dataclass(frozen=True)
class Speed:
    """Steps per second of a line and the pixel frequency that it is made for."""

    steps_s: float
    pixel_hz: int

    @property
    def count(self) -> int:
        """Steps of a pixel, 0 if one takes more than a pixel."""
        return int(self.steps_s / self.pixel_hz)


def pixel_hz(board: str) -> tuple[int, ...]:
    """Return the pixel frequencies of lines that wait for no clock."""
    of = boards.load(board)
    return tuple(
        hz
        for hz in _PIXEL_HZ
        if hz * of.axes <= _PIXELS_S and of.tick_hz <= hz * _LONGEST_PERIOD_TICKS
    )


def clock_hz(board: str) -> tuple[int, ...]:
    """Return the frequencies of the pixel clock that a board keeps up with."""
    return tuple(hz for hz in pixel_hz(board) if hz >= _SLOWEST_CLOCK_HZ)


def place_edges(tick_hz: int, hz: int) -> int:
    """Return how many edges a line zero lies behind the clock edge that it is placed from."""
    return _PLACE_TICKS // (tick_hz // hz) + 1


def go_ahead(tick_hz: int, hz: int) -> int:
    """Return how far ahead an edge must be for `go` to name it in time."""
    return place_edges(tick_hz, hz) + int(_GO_S * hz) + 2


def shortest_ticks(board: boards.BoardKind, *, smooth: bool) -> int:
    """Return the shortest interval of lines that every axis of a board makes at once."""
    if smooth:
        return steady_smooth_ticks(board)
    return board.min_interval_ticks + (17 if board.axes == 1 else 34)


def speed(rng: random.Random, board: str, hz: int, *, smooth: bool) -> Speed:
    """Return a speed from 1 step/s up, evenly spread over its logarithm."""
    table = boards.load(board)
    most = min(FASTEST, table.tick_hz / shortest_ticks(table, smooth=smooth))
    return Speed(most ** rng.random(), hz)


def entries(
    rng: random.Random, chosen: Speed, tick_hz: int, *, smooth: bool, clocked: bool
) -> Entries:
    """Return the queue entries of a line."""
    mark = MARK_START | (MARK_WAIT_FOR_EDGE if clocked else 0)
    if smooth and chosen.count >= 4:
        mark |= MARK_SMOOTH | (MARK_NEGATIVE if rng.random() < 0.5 else 0)
        runs = _smooth_runs(rng, chosen)
    else:
        runs = _plain_runs(rng, chosen, tick_hz)
    return ((mark, 0), (0, 0), *runs, (MARK_END, 0))


def _pixels(rng: random.Random, chosen: Speed) -> int:
    """Most lines outlast a trial, some are over soon."""
    return rng.randint(1, 3) if rng.random() < 0.2 else _LASTS_S * chosen.pixel_hz + 1


def _smooth_runs(rng: random.Random, chosen: Speed) -> list[tuple[int, int]]:
    quarter = chosen.count // 4
    rise = [(quarter, 1), (3 * quarter, 1)]
    return [*rise, (4 * quarter, _pixels(rng, chosen)), *reversed(rise)]


def _plain_runs(rng: random.Random, chosen: Speed, tick_hz: int) -> list[tuple[int, int]]:
    sign = rng.choice((-1, 1))
    lead = [(0, rng.randint(1, 3))] if rng.random() < 0.1 else []
    if chosen.count == 0:
        rest = max(1, int(chosen.pixel_hz / chosen.steps_s) - 1)
        return [*lead, *[(sign, 1), (0, rest)] * _SPARSE, (sign, 1)]
    count = sign * chosen.count
    turns = chosen.count * _REVERSAL_TICKS * chosen.pixel_hz < tick_hz and rng.random() < 0.3
    if turns:
        return [*lead, *[(count, 1), (-count, 1)] * _SPARSE]
    return [*lead, (count, _pixels(rng, chosen))]
