# SPDX-License-Identifier: MIT
"""Where the socket of a port's server is: a name that follows from the port's.

Both the port's name and what it leads to count, so that /dev/serial/by-id/... and /dev/ttyACM0 are
one port, and a link that leads to another terminal later is still the same one.
"""

import os
import stat
import tempfile
from collections.abc import Iterator
from pathlib import Path

from pixstep.errors import AskedText, UserError

SYSTEM = Path("/run/pixstep")  # of a server that the system has started
_MOST_NAME = 60  # characters: a socket's whole path may have 107
_SUFFIX = ".sock"


def folder() -> Path:
    """Return where a server puts its socket: where systemd says, or in a folder of the user."""
    given = os.environ.get("RUNTIME_DIRECTORY")
    return Path(given.partition(":")[0]) if given else _own()


def make_folder() -> Path:
    """Make that folder, for this user alone; raises UserError if another user can write there."""
    place = folder()
    try:
        place.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"{place}: {error.strerror}") from None
    if not _is_safe(place):
        raise UserError(AskedText(
            "{place}: another user can write there: name a {socket}", place=place
        ))  # fmt: skip
    return place


def names(port: str) -> list[str]:
    """Return the names of a port's sockets: by the port's own name, and by what that leads to."""
    found = [os.path.abspath(port), os.path.realpath(port)]  # noqa: PTH100 (links stay)
    return list(dict.fromkeys(_name(path) for path in found))


def known(port: str) -> Iterator[Path]:
    """Yield the sockets of a port's server that there may be, of safe folders alone."""
    for place in dict.fromkeys((folder(), _own(), SYSTEM)):
        for name in names(port):
            path = place / name
            if path.exists() and (place == SYSTEM or _is_safe(place)):
                yield path


def _own() -> Path:
    given = os.environ.get("XDG_RUNTIME_DIR")
    if given:
        return Path(given) / "pixstep"
    return Path(tempfile.gettempdir()) / f"pixstep-{os.getuid()}"


def _name(path: str) -> str:
    plain = path.strip("/").replace("/", "-")
    return plain[-_MOST_NAME:] + _SUFFIX


def _is_safe(place: Path) -> bool:
    """Whether only this user and root can put a socket into a folder, or a group that may."""
    try:
        found = place.stat()
    except OSError:
        return False
    return found.st_uid in (os.getuid(), 0) and not found.st_mode & stat.S_IWOTH
