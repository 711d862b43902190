# SPDX-License-Identifier: MIT
"""The runner's logs as arrays: edges, pixel clock, plants."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from pixstep.errors import RefusedError, UserError
from pixstep.lazy import np
from pixstep.simulation.small_pickle import SmallPickle

HEADER = "cycle,board,axis,signal,level"
_SIGNALS = ("STEP", "DIR", "ENABLE", "PERMIT", "CLOCK_OUT")
PLANT_HEADER = "cycle,board,axis,motor,load"
CLOCK_HEADER = "cycle,true_cycle_x1000,edge"
_CLOCK_EDGES = ("true", "missing", "false")
_MISSING, _FALSE = 1, 2
_BLOCK_BYTES = 1 << 26
_AXES = 256  # more than a board has
_PLANT_ROW = re.compile(r"\d+,\d+,\d+,-?\d+,-?\d+")
_ROW = re.compile(rf"\d+,\d+,\d+,({'|'.join(_SIGNALS)}),[01]")


def no_cycles() -> np.ndarray:
    """Return an array without a cycle."""
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class AxisEdges(SmallPickle):
    """The edges of one axis, in cycle order: cycles as int64.

    Levels are those after each edge; a pin that the program does not drive counts as low, so that
    all are low at reset. The permit output and CLOCK_OUT are the whole board's: their edges are
    with axis 0.
    """

    step_cycles: np.ndarray = field(default_factory=no_cycles)
    step_levels: np.ndarray = field(default_factory=no_cycles)
    direction_cycles: np.ndarray = field(default_factory=no_cycles)
    direction_levels: np.ndarray = field(default_factory=no_cycles)
    enable_cycles: np.ndarray = field(default_factory=no_cycles)
    enable_levels: np.ndarray = field(default_factory=no_cycles)
    permit_cycles: np.ndarray = field(default_factory=no_cycles)
    permit_levels: np.ndarray = field(default_factory=no_cycles)
    clock_out_cycles: np.ndarray = field(default_factory=no_cycles)
    clock_out_levels: np.ndarray = field(default_factory=no_cycles)

    @property
    def rising(self) -> np.ndarray:
        """Cycles of the rising STEP edges: the steps."""
        rising: np.ndarray = self.step_cycles[self.step_levels == 1]
        return rising

    def directions(self) -> np.ndarray:
        """Return +1 (DIR low) or -1 (DIR high) at every rising STEP edge."""
        index = np.searchsorted(self.direction_cycles, self.rising, side="right")
        levels = np.concatenate([[0], self.direction_levels])
        return np.where(levels[index] == 1, -1, 1).astype(np.int64)


@dataclass(frozen=True)
class ClockLog:
    """The edges of a pixel clock: those that the boards saw, and where the true ones belong.

    `true` are the times of the true edges without their jitter, missing ones included, in cycles.
    """

    seen: np.ndarray = field(default_factory=no_cycles)
    true: np.ndarray = field(default_factory=no_cycles)
    missing: int = 0
    false: int = 0


@dataclass(frozen=True)
class EdgeLog:
    """All edges of a run by (board, axis)."""

    axes: dict[tuple[int, int], AxisEdges] = field(default_factory=dict)

    def axis(self, board: int, axis: int) -> AxisEdges:
        """Return the edges of one axis; all empty if it had none."""
        return self.axes.get((board, axis), AxisEdges())


def read_edges(path: Path) -> EdgeLog:
    """Read edges.csv; raises UserError naming the line for a malformed one."""
    parts = []
    for first, body in blocks(path, HEADER):
        found_rows = _table(body)
        if found_rows is None:
            raise _malformed(path, first, body, _ROW, "an edge", "an edge list")
        parts.append(found_rows)
    table = np.concatenate([np.zeros((0, 5), dtype=np.int64), *parts])
    keys = table[:, 1] * _AXES + table[:, 2]
    found = np.flatnonzero(np.bincount(keys)).tolist()
    return EdgeLog({divmod(key, _AXES): _axis_edges(table[keys == key]) for key in found})


def read_clock(path: Path) -> np.ndarray:
    """Return the cycles of the edges that reached the boards, from the runner's clock log."""
    return read_clock_log(path).seen


def read_clock_log(path: Path) -> ClockLog:
    """Read clock.csv; raises UserError for what is none."""
    parts = [np.zeros((0, 3), dtype=np.int64)]
    for _, body in blocks(path, CLOCK_HEADER):
        for index, name in enumerate(_CLOCK_EDGES):
            body = body.replace(f",{name}\n".encode(), f",{index}\n".encode())
        table = numbers(body, 3)
        if table is None:
            raise RefusedError(f"{path}: not a clock log")
        parts.append(table)
    table = np.concatenate(parts)
    kinds = table[:, 2]
    return ClockLog(
        seen=table[kinds != _MISSING, 0],
        true=table[kinds != _FALSE, 1] / 1000,
        missing=int(np.sum(kinds == _MISSING)),
        false=int(np.sum(kinds == _FALSE)),
    )


def blocks(path: Path, header: str) -> Iterator[tuple[int, bytes]]:
    """Yield the rows of a log behind its header in blocks, each with the number of its first line.

    A log may be larger than memory. Raises UserError for another header.
    """
    try:
        with Path(path).open("rb") as file:
            if file.readline().rstrip(b"\n") != header.encode():
                raise RefusedError(f"{path}:1: the header is not {header!r}")
            line = 2
            while body := file.read(_BLOCK_BYTES):
                body += file.readline()
                yield line, body if body.endswith(b"\n") else body + b"\n"
                line += body.count(b"\n")
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None


def numbers(body: bytes, columns: int) -> np.ndarray | None:
    """Return the whole numbers of rows of so many columns; None if they are not that.

    All rows are converted at once: a run of seconds has a million of them.
    """
    rows = body.count(b"\n")
    if body.count(b",") != (columns - 1) * rows:
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # what is no number ends the array
        try:
            found = np.fromstring(body.replace(b"\n", b","), dtype=np.int64, sep=",")
        except ValueError:  # or is an error
            return None
    return found.reshape(rows, columns) if len(found) == columns * rows else None


def _table(body: bytes) -> np.ndarray | None:
    """Return the rows as integers, the signal by its place in _SIGNALS; None if one is wrong."""
    rows, named = body.count(b"\n"), 0
    for index, name in enumerate(_SIGNALS):
        named += body.count(f",{name},".encode())
        body = body.replace(f",{name},".encode(), f",{index},".encode())
    table = numbers(body, 5) if named == rows else None
    if table is None:
        return None
    fine = np.all(table >= 0) and np.all(table[:, 2] < _AXES) and np.all(table[:, 4] <= 1)
    return table if fine else None


def _axis_edges(table: np.ndarray) -> AxisEdges:
    columns = []
    for name in _SIGNALS:
        chosen = table[table[:, 3] == _SIGNALS.index(name)]
        columns += [chosen[:, 0], chosen[:, 4]]
    return AxisEdges(*columns)


@dataclass(frozen=True)
class AxisPlant:
    """One axis, in cycle order, as int64: cycles, and motor and load (steps) from then on.

    The first row is where both are at reset.
    """

    cycles: np.ndarray
    motor: np.ndarray
    load: np.ndarray

    def load_at(self, cycles: np.ndarray) -> np.ndarray:
        """Return the load's steps from its start, moves at exactly a cycle included."""
        index = np.searchsorted(self.cycles, cycles, side="right") - 1
        moved: np.ndarray = self.load[np.maximum(index, 0)] - self.load[0]
        return moved


def read_plant(path: Path) -> dict[tuple[int, int], AxisPlant]:
    """Read a plant log by (board, axis); raises UserError naming the line of a malformed one."""
    parts: dict[tuple[int, int], list[np.ndarray]] = {}
    for first, body in blocks(path, PLANT_HEADER):
        rows = numbers(body, 5)
        if rows is None:
            raise _malformed(path, first, body, _PLANT_ROW, "a row of a plant log", "a plant log")
        places = rows[:, 1] * _AXES + rows[:, 2]
        for place in np.unique(places).tolist():
            mine = rows[places == place][:, [0, 3, 4]]
            parts.setdefault(divmod(place, _AXES), []).append(mine)
    return {key: AxisPlant(*np.concatenate(tables).T) for key, tables in parts.items()}


def _malformed(
    path: Path, first: int, body: bytes, form: re.Pattern[str], row: str, log: str
) -> RefusedError:
    """Return the refusal of the first row that is none; `first` is the number of its first line."""
    for number, text in enumerate(body.decode("ascii", "replace").splitlines(), first):
        if not form.fullmatch(text):
            return RefusedError(f"{path}:{number}: {text!r} is not {row}")
    return RefusedError(f"{path}: not {log}")
