# SPDX-License-Identifier: MIT
"""Looking for boards: every address, and every rate and parity if asked."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pixstep.board import registers as regs
from pixstep.board.device import Device
from pixstep.board.errors import ExceptionReplyError, NoReplyError
from pixstep.progress import Progress, unseen

if TYPE_CHECKING:
    from pixstep.board.modbus import Client

UNITS = range(1, 248)
BAUDS = (115_200, 19_200, 9_600, 38_400, 57_600, 250_000, 500_000, 1_000_000)
TIMEOUT_S = 0.08
_HEAD_WORDS = 6  # map, firmware, board, axes, status, fault


@dataclass(frozen=True)
class ScannedBoard:
    """What answered at an address; `trouble` says why it is not a board to talk to."""

    unit: int
    board: str = ""
    firmware: str = ""
    map_version: int = 0
    axes: int = 0
    status: str = ""
    fault: str = ""
    trouble: str = ""

    def as_json(self) -> dict[str, object]:
        """Return plain data."""
        return dict(vars(self))


def scan(
    modbus: Client, units: Iterable[int] = UNITS, progress: Progress = unseen
) -> list[ScannedBoard]:
    """Ask every address once; return what answered."""
    wanted = list(units)
    found = []
    for index, unit in enumerate(wanted):
        progress(index / len(wanted))
        answer = look(Device(modbus, unit))
        if answer:
            found.append(answer)
    return found


def look(board: Device) -> ScannedBoard | None:
    """Return what answers at one address; None if nothing does."""
    try:
        words = board.read_inputs(0, _HEAD_WORDS)
    except ExceptionReplyError as error:
        return ScannedBoard(board.unit, trouble=f"another device (exception {error.code})")
    except NoReplyError as error:
        if not error.heard:
            return None
        text = f"unreadable ({error.heard} bytes): two boards with this address, or another rate"
        return ScannedBoard(board.unit, trouble=text)
    version, firmware, board_id, axes, status, fault = words
    trouble = "" if version == regs.MAP_VERSION else f"this tool knows map {regs.MAP_VERSION}"
    return ScannedBoard(
        unit=board.unit,
        board=regs.BOARD_IDS.get(board_id, f"board {board_id}"),
        firmware=regs.version_text(firmware),
        map_version=version,
        axes=axes,
        status=regs.words(board.map.input("status"), status),
        fault=regs.code_name(regs.faults(), fault) if fault else "",
        trouble=trouble,
    )


@contextlib.contextmanager
def quickly(modbus: Client, timeout_s: float = TIMEOUT_S) -> Iterator[None]:
    """Let a client ask once only and wait briefly, as long as this lasts."""
    with modbus.patient(timeout_s, 0):
        yield
