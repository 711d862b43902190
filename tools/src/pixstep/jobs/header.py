# SPDX-License-Identifier: MIT
"""job.toml: what a job is and what it was made with; the sums of its other members.

The last table, [seal], has the SHA-256 of all text before it, and [sha256] that of each other
member: so every member is held by a sum, and this one by its own. A seal tells damage from content;
it is no signature.
"""

from __future__ import annotations

import datetime
import hashlib
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal

import tomlkit
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pixstep.errors import RefusedError, one_line
from pixstep.version import __version__

NAME = "job.toml"
SCHEMA: Literal[1] = 1
_SEAL = "\n[seal]\n"
Count = Annotated[int, Field(ge=0)]
_OF_FILE = ("file", "file_hz", "file_motor")


class _JobTable(BaseModel):
    """A table of job.toml: no key but those that are known."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, populate_by_name=True)


class MadeTable(_JobTable):
    """When, and by which pixstep."""

    at: datetime.datetime
    by: str


class SourceTable(_JobTable):
    """What the lines come from, and the files that say it."""

    kind: Literal["image", "lines", "table", "useq", "scanspec"]
    files: dict[str, str] = {}  # name and sha256


class JobLineTable(_JobTable):
    """What all lines have in common; lengths in pixels, offsets in steps of the scanning motor."""

    lines: Count
    pixels: Count
    image_pixels: Count = 0
    lead_in: Count = 0
    lead_out: Count = 0
    alternate: bool = True
    scan_offset_forward: int = 0
    scan_offset_back: int = 0


class JobMotorTable(_JobTable):
    """What a motor's lines were made with: steps, and steps/pixel.

    `profiles` are the members with its profiles, by use: line, move, home, and own, a line profile
    that was named when the job was made. `used` is the one that the lines were made by. Of lines
    of a file `file` is its name, `file_hz` and `file_motor` what it says it was made for; an empty
    one is not written.
    """

    role: Literal["scan", "step", "turn", "still", "lines"]
    decode: Literal["smooth", "plain"]
    backlash: Count = 0
    speed: Count = 0
    distance: int = 0
    used: Literal["", "line", "move", "own"] = ""
    file: str = ""
    file_hz: str = ""
    file_motor: str = ""
    profiles: dict[str, str] = {}


class JobHeader(_JobTable):
    """What job.toml says."""

    schema_version: Literal[1] = Field(1, alias="schema")
    id: str
    resumable: bool = True
    made: MadeTable
    source: SourceTable
    line: JobLineTable
    motors: dict[str, JobMotorTable]
    settings: dict[str, str] = {}  # members with the settings of boards, by the board's name
    sha256: dict[str, str] = {}

    def text(self) -> str:
        """Return the file, sealed."""
        content = self.model_dump(by_alias=True)
        for motor in content["motors"].values():
            for key in _OF_FILE:
                if not motor[key]:
                    del motor[key]
        document = tomlkit.document()
        document.add(tomlkit.comment("A print job of pixstep: `pixstep job show` tells of it."))
        for key, value in content.items():
            document[key] = value
        body = tomlkit.dumps(document)
        return f'{body}{_SEAL}sha256 = "{_sum(body.encode())}"\n'


def made_now(at: datetime.datetime) -> MadeTable:
    """Return who makes a job."""
    return MadeTable(at=at.astimezone(datetime.UTC).replace(microsecond=0), by=__version__)


def sums(members: dict[str, bytes]) -> dict[str, str]:
    """Return the SHA-256 of each member but this one."""
    return {name: _sum(data) for name, data in members.items() if name != NAME}


def read(path: Path, members: dict[str, bytes]) -> JobHeader:
    """Return what a job says of itself, once every member is as its sum says.

    Raises RefusedError naming the file and the member.
    """
    text = members[NAME]
    body, found, seal = text.rpartition(_SEAL.encode())
    if not found or seal != f'sha256 = "{_sum(body)}"\n'.encode():
        raise RefusedError(f"{path}: member {NAME} is not as its seal says")
    content = _content(path, body)
    _refuse_newer(path, content)
    try:
        header = JobHeader.model_validate(content)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False)[0]
        place = ".".join(map(str, first["loc"]))
        raise RefusedError(f"{path}: {NAME}: {place}: {one_line(first['msg'])}") from None
    _check_sums(path, header, members)
    return header


def _content(path: Path, body: bytes) -> dict[str, Any]:
    try:
        return tomllib.loads(body.decode())
    except ValueError as error:
        raise RefusedError(f"{path}: {NAME}: {one_line(str(error))}") from None


def _refuse_newer(path: Path, content: dict[str, Any]) -> None:
    version = content.get("schema")
    if type(version) is not int or version > SCHEMA:
        made = content.get("made")
        by = made.get("by", "?") if isinstance(made, dict) else "?"
        raise RefusedError(
            f"{path}: {NAME}: schema = {version}: made by pixstep {one_line(str(by))}; this one, "
            f"{__version__}, reads schema {SCHEMA}: take a newer pixstep"
        )


def _check_sums(path: Path, header: JobHeader, members: dict[str, bytes]) -> None:
    there = sums(members)
    for name in sorted(there.keys() | header.sha256.keys()):
        if name not in there:
            raise RefusedError(f"{path}: member {name} is missing")
        if header.sha256.get(name) != there[name]:
            raise RefusedError(f"{path}: member {name} is not as its sha256 in {NAME} says")


def _sum(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
