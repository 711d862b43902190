# SPDX-License-Identifier: MIT
"""The independent reference: exact step instants, pixel edges and expected positions.

Nothing here rounds. A step instant in ticks after line zero is (x + y*sqrt(d)) / e with integers,
so that its floor, and whether it lies at or before a rational bound, are decided by integer square
roots. `instants` is a second, fast path in floating point for statistics over long lines; its
error is below 1e-6 tick. The firmware's code shares nothing with this file.

Model (see the line's `shifted_pixels`): pixel k covers [k-1, k] pixel periods after line zero; with
backlash B at line speed V the first pixels, up to the boundary where V is reached, run B/V of a
period early and B steps at speed V fill the gap.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import isqrt, sqrt

from pixstep.lazy import np
from pixstep.lines.line import Line

_TOGETHER = 4096  # pieces whose steps are in memory at once, besides their instants


@dataclass(frozen=True, slots=True)
class Instant:
    """An exact time in ticks: (x + y*sqrt(d)) / e, with e > 0 and d >= 0, all integers."""

    x: int
    y: int
    d: int
    e: int

    def floor(self) -> int:
        """Return the largest integer not above the instant."""
        return (self.x + _floor_sqrt(self.y, self.d)) // self.e

    def is_integer(self) -> bool:
        """True if the instant falls exactly on a tick."""
        root = isqrt(self.d)
        return root * root == self.d and (self.x + self.y * root) % self.e == 0

    def later(self, ticks: Fraction) -> Instant:
        """Return the instant that is so many ticks later."""
        part, parts = ticks.numerator, ticks.denominator
        return Instant(self.x * parts + part * self.e, self.y * parts, self.d, self.e * parts)

    def at_or_before(self, bound: Fraction) -> bool:
        """True if the instant is <= `bound` ticks, in exact arithmetic."""
        # y*sqrt(d) <= bound*e - x, after multiplying by the bound's denominator
        right = bound.numerator * self.e - self.x * bound.denominator
        left = self.y * bound.denominator
        if left >= 0:
            return right >= 0 and left * left * self.d <= right * right
        return right >= 0 or left * left * self.d >= right * right

    def strictly_within_one(self, tick: int) -> bool:
        """True if |tick - instant| < 1 in exact arithmetic."""
        whole = self.floor()
        return tick == whole or (tick == whole + 1 and not self.is_integer())

    def __float__(self) -> float:
        return (self.x + self.y * sqrt(self.d)) / self.e


@dataclass(frozen=True, slots=True)
class Piece:
    """Consecutive steps of one constant acceleration.

    `pixel` is the 1-based pixel they belong to (the inserted backlash belongs to the last shifted
    one), `begin` where the acceleration's own period begins, in pixel periods after line zero.
    """

    pixel: int
    begin: Fraction
    speed: int
    accel: int
    steps: int
    direction: int


def pieces(line: Line) -> Iterator[Piece]:
    """Yield the pieces of a line in order, those without steps included."""
    shift = Fraction(line.backlash, line.line_speed) if line.shifted_pixels else Fraction(0)
    speed = 0
    for pixel, count in enumerate(line.counts, 1):
        begin = Fraction(pixel - 1) - (shift if pixel <= line.shifted_pixels else 0)
        if line.smooth:
            yield Piece(pixel, begin, speed, 2 * (count - speed), count, line.direction)
            speed = 2 * count - speed
        else:
            yield Piece(pixel, begin, abs(count), 0, abs(count), -1 if count < 0 else 1)
        if line.shifted_pixels == pixel:
            yield Piece(pixel, pixel - shift, speed, 0, line.backlash, line.direction)


def instant(piece: Piece, step: int, period: Fraction) -> Instant:
    """Return the exact instant of step `step` (1-based) of a piece; `period` in ticks."""
    p, q = period.numerator, period.denominator
    n, m = piece.begin.numerator, piece.begin.denominator
    v, a = piece.speed, piece.accel
    if a == 0:  # P * (n/m + step/v)
        return Instant(p * (n * v + step * m), 0, 0, q * m * v)
    # P * (n/m + (sqrt(v*v + 2*a*step) - v) / a)
    sign = 1 if a > 0 else -1
    return Instant(sign * p * (n * a - m * v), sign * p * m, v * v + 2 * a * step, sign * q * m * a)


def exact_instants(line: Line, period: Fraction) -> Iterator[tuple[int, Instant]]:
    """Yield (pixel, instant) of every step pulse of the line, in order."""
    for piece in pieces(line):
        for step in range(1, piece.steps + 1):
            yield piece.pixel, instant(piece, step, period)


@dataclass(frozen=True, slots=True)
class PieceTable:
    """The pieces of a line in columns, a row each: of a long line far quicker than one by one.

    A piece begins `begin_parts` / `parts` pixel periods after line zero.
    """

    begin_parts: list[int]
    parts: int
    speed: np.ndarray
    accel: np.ndarray
    steps: np.ndarray
    direction: np.ndarray

    @classmethod
    def of(cls, line: Line) -> PieceTable:
        """Return the pieces of a line."""
        counts = np.array(line.counts, dtype=np.int64)
        if line.smooth:
            speed = np.array(line.speeds[:-1], dtype=np.int64)
            accel, steps = 2 * (counts - speed), np.maximum(counts, 0)
            direction = np.full(len(counts), line.direction, dtype=np.int64)
        else:
            speed = steps = np.abs(counts)
            accel, direction = np.zeros_like(counts), np.where(counts < 0, -1, 1)
        shifted = line.shifted_pixels
        if not shifted:
            return cls(list(range(line.pixels)), 1, speed, accel, steps, direction)
        ahead, parts = line.backlash, line.line_speed
        early = range(-ahead, (shifted + 1) * parts - ahead, parts)  # and the piece that fills up
        return cls(
            [*early, *range(shifted * parts, line.pixels * parts, parts)],
            parts,
            np.insert(speed, shifted, line.line_speed),
            np.insert(accel, shifted, 0),
            np.insert(steps, shifted, line.backlash),
            np.insert(direction, shifted, line.direction),
        )

    @property
    def begin(self) -> np.ndarray:
        """Where pieces begin, in pixel periods after line zero."""
        return np.array([part / self.parts for part in self.begin_parts])


def instants_of(line: Line, period: Fraction, indices: Sequence[int]) -> Iterator[Instant]:
    """Yield the exact instants of some steps, by their index from 0 on."""
    table = PieceTable.of(line)
    done = np.cumsum(table.steps)
    for index, row in zip(indices, np.searchsorted(done, indices, side="right"), strict=True):
        begin = Fraction(table.begin_parts[row], table.parts)
        speed, accel, steps = int(table.speed[row]), int(table.accel[row]), int(table.steps[row])
        piece = Piece(0, begin, speed, accel, steps, int(table.direction[row]))
        yield instant(piece, index + 1 - int(done[row]) + steps, period)


def directions(line: Line) -> np.ndarray:
    """Return +1 or -1 for every step pulse of the line."""
    table = PieceTable.of(line)
    return np.repeat(table.direction, table.steps)


def instants(line: Line, period: Fraction) -> np.ndarray:
    """Return the instants of every step in ticks as float64, the pixel begin kept exact."""
    table = PieceTable.of(line)
    below = period.denominator * table.parts
    starts = [divmod(part * period.numerator, below) for part in table.begin_parts]
    whole = np.array([start for start, _ in starts], dtype=np.float64)
    rest = np.array([left / below for _, left in starts], dtype=np.float64)
    found = [np.zeros(0)]
    for begin in range(0, len(starts), _TOGETHER):
        rows = slice(begin, begin + _TOGETHER)
        steps = table.steps[rows]
        piece = begin + np.repeat(np.arange(len(steps)), steps)
        step = 1.0 + np.arange(len(piece)) - np.repeat(np.cumsum(steps) - steps, steps)
        speed = table.speed[piece].astype(np.float64)
        root = np.sqrt(np.maximum(speed**2 + 2.0 * table.accel[piece] * step, 0.0))
        # 2j / (v + root) is the stable form of (root - v) / a, and right for a = 0 too
        offset = float(period) * 2.0 * step / (speed + root)
        found.append(whole[piece] + (rest[piece] + offset))
    return np.concatenate(found)


def expected_positions(line: Line) -> list[int]:
    """Return the steps made at the end edge of every pixel, signed: the closed form of the table.

    Inside the shifted part the edge falls B/V into the next pixel of the profile, where the
    position is floor(S + v*b + a*b*b/2); steps exactly on the edge count.
    """
    beta = Fraction(line.backlash, line.line_speed) if line.shifted_pixels else Fraction(0)
    table = []
    done = 0
    for pixel, count in enumerate(line.counts, 1):
        done += count * line.direction
        if pixel < line.shifted_pixels:
            speed, following = line.speeds[pixel], line.counts[pixel]
            inside = speed * beta + (following - speed) * beta * beta
            table.append(done + line.direction * (inside.numerator // inside.denominator))
            continue
        if pixel == line.shifted_pixels:
            done += line.direction * line.backlash
        table.append(done)
    return table


def edge_ends(line: Line) -> list[tuple[int, int]]:
    """Return (pixel, steps made) for every pixel whose last step falls exactly on its end edge.

    These are the pixels with steps that the backlash does not shift, and the last shifted one,
    where the inserted steps end on the edge.
    """
    ends = []
    done = 0
    for pixel, count in enumerate(line.counts, 1):
        done += abs(count)
        if pixel == line.shifted_pixels:
            done += line.backlash
        if pixel >= line.shifted_pixels and (count or pixel == line.shifted_pixels):
            ends.append((pixel, done))
    return ends


def _floor_sqrt(factor: int, radicand: int) -> int:
    """Return floor(factor * sqrt(radicand)) exactly, for a factor of either sign."""
    square = factor * factor * radicand
    root = isqrt(square)
    if factor >= 0:
        return root
    return -(root if root * root == square else root + 1)
