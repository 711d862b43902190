# SPDX-License-Identifier: MIT
"""The container of a job: a ZIP of stored members whose every byte follows from its members.

There is one way only to write given members, and a reader writes them again and compares: so no
byte can be another one, between the members either, without the member being named. Any other
program for ZIP files reads the container too.
"""

from __future__ import annotations

import io
import struct
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pixstep.errors import RefusedError, UserError

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
