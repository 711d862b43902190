# SPDX-License-Identifier: MIT
"""What records keep over a restart: their settings, and where their motors are.

The file is written whole or not at all. A setting that a client has written holds until the
machine file's own value of that field changes. A position is kept as it is, in motion as well; the
record's field RSTM decides when it is written to the board.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pixstep import atomic
from pixstep.errors import UserError

if TYPE_CHECKING:
    from pixstep.motor_record.field import Value

_FORM = 1
_COUNTS = ("register_steps", "offset_steps")
SETTINGS = (
    "DESC", "EGU", "PREC", "MRES", "SREV", "UREV", "ERES", "RRES", "DIR", "OFF", "FOFF",
    "UEIP", "URIP", "RDBL", "DOL", "OMSL", "RDBD", "SPDB", "RTRY", "RMOD", "FRAC", "DLY",
    "BDST", "BVEL", "BACC", "VELO", "VBAS", "VMAX", "ACCL", "ACCS", "ACCU", "JVEL", "JAR", "HVEL",
    "TWV", "DHLM", "DLLM", "HLSV", "HOPR", "LOPR", "HIHI", "HIGH", "LOW", "LOLO", "HHSV", "HSV",
    "LSV", "LLSV", "MDEL", "ADEL", "NTM", "NTMF", "RSTM", "PCOF", "ICOF", "DCOF",
)  # fmt: skip
_KINDS = {"given": dict, "fields": dict, "moving": bool, **dict.fromkeys(_COUNTS, int)}
_POSITION = "DVAL"
_UNIT = "EGU"

Fields = Mapping[str, "Value"]


@dataclass(frozen=True)
class SavedRecord:
    """A record as it was, or as the machine file gives it where nothing was kept of it.

    Where a position was set, the record's raw position is the board's register and an offset that
    the drive had; a board that was reset since has its register at 0.
    """

    fields: dict[str, Value]
    is_moving: bool = False
    register_steps: int = 0
    offset_steps: int = 0

    def offset_at(self, register_steps: int) -> int:
        """Return the offset that holds still, where a board's register is now."""
        was_reset = register_steps == 0 != self.register_steps
        return 0 if was_reset else self.offset_steps


class Saved:
    """The file of one server; nothing is kept without a path."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self._motors: dict[str, dict[str, Any]] = _read(path) if path else {}
        self._written = json.dumps(self._motors)

    def kept(self, name: str, given: Fields) -> SavedRecord:
        """Return a record; `given` are the fields of the machine file."""
        kept = self._motors.get(name)
        if kept is None or kept["given"].get(_UNIT) != given.get(_UNIT):
            return SavedRecord(dict(given))
        same = {
            field: value
            for field, value in kept["fields"].items()
            if field == _POSITION or kept["given"].get(field) == given.get(field)
        }
        return SavedRecord({**given, **same}, kept["moving"], *(kept[count] for count in _COUNTS))

    def note(
        self, name: str, given: Fields, record: Any, *, is_moving: bool, offset_steps: int = 0
    ) -> None:
        """Note how a record is; `given` are the fields of the machine file."""
        fields = {field: record[field] for field in SETTINGS}
        fields[_POSITION] = record["DRBV"]
        self._motors[name] = {
            "given": dict(given),
            "fields": fields,
            "moving": is_moving,
            "register_steps": record["RMP"] - offset_steps,
            "offset_steps": offset_steps,
        }

    def write(self) -> bool:
        """Write what was noted if it is new; return whether it was. Raises UserError."""
        text = json.dumps(self._motors)
        if self.path is None or text == self._written:
            return False
        with atomic.rules(atomic.WriteRules(force=True)):
            atomic.write_json(self.path, {"pixstep_ioc": _FORM, "motors": self._motors})
        self._written = text
        return True


def _read(path: Path) -> dict[str, dict[str, Any]]:
    """Return what a file holds, nothing if it is not there."""
    wrong = f"{path}: is not a file of `pixstep ioc` (remove it, and the IOC begins without it)"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise UserError(f"{path}: {error.strerror or error}") from None
    except ValueError:
        raise UserError(wrong) from None
    try:
        motors = content["motors"]
        is_right = content["pixstep_ioc"] == _FORM and all(
            isinstance(one[key], kind) for one in motors.values() for key, kind in _KINDS.items()
        )
    except (TypeError, KeyError, AttributeError):
        is_right = False
    if not is_right:
        raise UserError(wrong)
    return dict(motors)
