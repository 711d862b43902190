# SPDX-License-Identifier: MIT
"""The container of a job: a ZIP of stored members whose every byte follows from its members.

There is one way only to write given members, and a reader writes them again and compares: so no
byte can be another one, between the members either, without the member being named. Any other
program for ZIP files reads the container too.

The two tables of a job as Parquet: shapes with their expected positions, and who runs which.

Any program that reads Parquet reads them. Shapes come in groups of rows, so that one line of a
large job is read without the others.
"""

from __future__ import annotations

import contextlib
import io
import struct
import zipfile
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from itertools import accumulate
from pathlib import Path
from typing import Any

from pixstep.errors import RefusedError, UserError, one_line
from pixstep.jobs.shapes import MotorRun, Shape
from pixstep.lazy import parquet, pyarrow, require_package

_GROUP = 192  # rows
_GROUPS_KEPT = 8
_LISTS = ("counts", "expected")
_PACKED = {f"{name}.list.element": "DELTA_BINARY_PACKED" for name in _LISTS}
_COLUMNS = tuple(one.name for one in fields(MotorRun))
_SHARED = [k for k, one in enumerate(fields(MotorRun)) if one.type in ("str", "bytes")]
_ROWS = 1024


def pack_shapes(shapes: Iterable[Shape]) -> bytes:
    """Return the table of shapes, each once, in the order in which they are first used."""
    rows = list(shapes)
    columns = {
        "shape": pyarrow.array([one.key for one in rows], pyarrow.binary()),
        "decode": pyarrow.array([one.decode for one in rows], pyarrow.string()),
        "backlash": pyarrow.array([one.backlash for one in rows], pyarrow.int32()),
        "counts": pyarrow.array([one.counts for one in rows], pyarrow.list_(pyarrow.int32())),
        "expected": pyarrow.array([one.expected for one in rows], pyarrow.list_(pyarrow.int64())),
    }
    return _packed(pyarrow.table(columns), column_encoding=_PACKED, use_dictionary=False)


def pack_runs(runs: Iterable[MotorRun]) -> bytes:
    """Return the table of who runs which shape, a row a motor and line."""
    rows = list(runs)
    kinds = {
        "line": pyarrow.int32(), "motor": pyarrow.string(), "shape": pyarrow.binary(),
        "negative": pyarrow.bool_(), "start_steps": pyarrow.int64(),
        "play_side": pyarrow.string(), "image_pixel": pyarrow.int32(),
        "pixels": pyarrow.int32(), "purpose": pyarrow.string(),
    }  # fmt: skip
    columns = {
        name: pyarrow.array([getattr(one, name) for one in rows], kinds[name]) for name in _COLUMNS
    }
    return _packed(pyarrow.table(columns))


def unpack_runs(data: bytes) -> list[MotorRun]:
    """Return the rows of the table of lines. Raises RefusedError for what is no such table."""
    runs: list[MotorRun] = []
    same: dict[Any, Any] = {}  # texts and keys: ten thousand lines have few different ones
    with _readable("lines"):
        # Part by part, so that a long table takes no memory besides its rows.
        found = parquet.ParquetFile(pyarrow.BufferReader(data))
        for part in found.iter_batches(_ROWS, columns=list(_COLUMNS), use_threads=False):
            columns = [part.column(name).to_pylist() for name in _COLUMNS]
            for k in _SHARED:
                columns[k] = [same.setdefault(value, value) for value in columns[k]]
            runs += (MotorRun(*row) for row in zip(*columns, strict=True))
    return runs


@contextlib.contextmanager
def _readable(what: str) -> Iterator[None]:
    """Let what is no table of this kind be refused in one line."""
    try:
        yield
    except (pyarrow.ArrowException, KeyError, OSError) as error:
        raise RefusedError(f"no table of {what}: {one_line(str(error))}") from None


class ShapeTable(Mapping[bytes, Shape]):
    """The shapes of a job by their keys, read when they are asked for."""

    def __init__(self, data: bytes) -> None:
        require_package("pyarrow")
        with _readable("shapes"):
            self._file = parquet.ParquetFile(pyarrow.BufferReader(data))
        self._group = lru_cache(_GROUPS_KEPT)(self._read)

    def __getitem__(self, key: bytes) -> Shape:
        row = self._rows[key]
        group = bisect_right(self._begins, row) - 1
        return self._group(group)[row - self._begins[group]]

    def __iter__(self) -> Iterator[bytes]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)

    @cached_property
    def _rows(self) -> dict[bytes, int]:
        with _readable("shapes"):
            keys = self._file.read(columns=["shape"]).column("shape").to_pylist()
        return {key: row for row, key in enumerate(keys)}

    @cached_property
    def _begins(self) -> list[int]:
        about = self._file.metadata
        sizes = (about.row_group(k).num_rows for k in range(about.num_row_groups))
        return [0, *accumulate(sizes)][:-1]

    def _read(self, group: int) -> Sequence[Shape]:
        with _readable("shapes"):
            return [_shape(row) for row in self._file.read_row_group(group).to_pylist()]


def _shape(row: dict[str, Any]) -> Shape:
    """Return the shape of a row. Raises RefusedError for one that is not what its key says."""
    made = Shape(tuple(row["counts"]), row["decode"], row["backlash"], tuple(row["expected"]))
    if made.key != row["shape"] or len(made.expected) != len(made.counts):
        raise RefusedError(f"shape {row['shape'].hex()}: its counts are not those of its key")
    return made


def _packed(table: pyarrow.Table, **more: Any) -> bytes:
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(
        table, sink, compression="zstd", row_group_size=_GROUP, write_statistics=False,
        store_schema=False, **more,
    )  # fmt: skip
    return bytes(sink.getvalue().to_pybytes())


Members = dict[str, bytes]

MOST_BYTES = 1 << 30
_DATE = (1980, 1, 1, 0, 0, 0)
_UNIX, _VERSION, _RIGHTS = 3, 20, 0o100644 << 16
_HEAD = struct.Struct("<18xI4xHH")  # size; lengths of the name and of what follows the name
_DIRECTORY_SIGNATURE = b"PK\x01\x02"
_DIRECTORY = "the list of members at its end"


@dataclass(frozen=True)
class _Place:
    """A member in a container: the head begins at `begin`, its data are said to end at `end`."""

    name: str
    begin: int
    end: int
    data: bytes


def pack(members: Members) -> bytes:
    """Return the only container that holds some members in their order."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED) as archive:
        for name, data in members.items():
            archive.writestr(_info(name), data)
    return stream.getvalue()


def unpack(path: Path, data: bytes, first: str) -> Members:
    """Return the members of a container, of which the first one has a name that is known.

    Raises RefusedError naming the file, and the member in which the first wrong byte is.
    """
    places = [*_walk(data)]
    if not places or places[0].name != first:
        raise RefusedError(f"{path}: no job file: {first} is not its first member")
    members = {place.name: place.data for place in places}
    right = pack(members)
    if right != data:
        raise RefusedError(f"{path}: {_what_is_wrong(places, right, data)}")
    return members


def load(path: Path) -> bytes:
    """Return the bytes of a file. Raises UserError for one that cannot be read."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise RefusedError(f"{path}: larger than {MOST_BYTES >> 20} MiB: no job is")
        return path.read_bytes()
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None


def _info(name: str) -> zipfile.ZipInfo:
    """Return the head of a member, in which nothing depends on time, system or version."""
    info = zipfile.ZipInfo(name, _DATE)
    info.create_system, info.external_attr = _UNIX, _RIGHTS
    info.create_version = info.extract_version = _VERSION
    info.compress_type = zipfile.ZIP_STORED
    return info


def _walk(data: bytes) -> Iterator[_Place]:
    """Yield the members one after the other, as far as their heads lead.

    A head's signature is not looked at, so that a member is named whose signature is wrong.
    """
    at = 0
    while len(data) >= at + _HEAD.size and data[at : at + 4] != _DIRECTORY_SIGNATURE:
        size, name_bytes, more_bytes = _HEAD.unpack_from(data, at)
        begin = at + _HEAD.size + name_bytes + more_bytes
        name = _name(data[at + _HEAD.size : at + _HEAD.size + name_bytes])
        if not name:
            return
        yield _Place(name, at, begin + size, data[begin : begin + size])
        at = begin + size


def _name(data: bytes) -> str:
    """Return a member's name, "" for bytes that are none."""
    try:
        name = data.decode("utf-8")
    except UnicodeDecodeError:
        return ""
    return name if name.isprintable() else ""


def _what_is_wrong(places: list[_Place], right: bytes, data: bytes) -> str:
    """Return what is wrong with a container that is not the one of its members."""
    if data.startswith(right):
        return f"damaged: {len(data) - len(right)} bytes follow {_DIRECTORY}"
    pairs = enumerate(zip(right, data, strict=False))
    at = next((k for k, (one, other) in pairs if one != other), len(data))
    if places[-1].end > len(data):
        return f"damaged or cut short in member {places[-1].name}"
    if at == len(data):
        return f"cut short in {_DIRECTORY}"
    inside = (place.name for place in places if place.begin <= at < place.end)
    named = next(inside, None)
    return f"damaged in member {named}" if named else f"damaged or cut short in {_DIRECTORY}"
