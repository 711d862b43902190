# SPDX-License-Identifier: MIT
"""The conventional names of profile files: AccProf<motor>-<f>Hz-<variant>.PRN.

A motor may have any name that a file's name can hold. Of those of the printer, M and two digits,
M39 is smooth and the others are plain; how another one decodes says its machine file.
"""

import re
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.units import parse_hz

SMOOTH_MOTORS = ("M39",)
_STEM = r"AccProf(.+)-(\d+(?:\.\d+)?)Hz-(\w+)"
_NAME = re.compile(rf"{_STEM}\.(?:PRN|CSV|CSB)", re.IGNORECASE)
_HEADER_NAME = re.compile(_STEM, re.IGNORECASE)
_OF_PRINTER = re.compile(r"M\d{2}", re.IGNORECASE)
_NO_NAME = re.compile(r"[/\\\x00-\x1f\x7f]")  # what no file's name should have


@dataclass(frozen=True)
class ProfileName:
    """What a conventional name says."""

    motor: str
    pixel_hz: Fraction
    variant: str

    @property
    def decode(self) -> str | None:
        """How the motor decodes printing lines: smooth or plain; None if its name does not say."""
        if not _OF_PRINTER.fullmatch(self.motor):
            return None
        return SMOOTH if self.motor in SMOOTH_MOTORS else PLAIN


def parse(path: Path) -> ProfileName | None:
    """Return what the name of a file says, None if it is not a conventional one."""
    found = _NAME.fullmatch(path.name)
    if not found:
        return None
    return ProfileName(_motor(found[1]), parse_hz(found[2]), found[3])


def motor_of(path: Path, header_name: str | None = None) -> str | None:
    """Return the motor that a file's header, else its own name, is for; None if neither says."""
    found = _HEADER_NAME.fullmatch(header_name.strip()) if header_name else None
    if found:
        return _motor(found[1])
    if header_name and _OF_PRINTER.fullmatch(header_name.strip()):
        return _motor(header_name.strip())
    named = parse(path)
    return named.motor if named else None


def _motor(name: str) -> str:
    return name.upper() if _OF_PRINTER.fullmatch(name) else name


def conventional(motor: str, hz: Fraction, variant: str, suffix: str = "PRN") -> str:
    """Return the conventional name. Raises UserError for a motor or variant that does not fit."""
    if not motor or _NO_NAME.search(motor):
        raise UserError(f"motor {motor!r}: its name cannot be a part of a file's name")
    if not re.fullmatch(r"\w+", variant):
        raise UserError(f"variant {variant!r}: expected letters, digits or underscores")
    return f"AccProf{motor}-{float(hz):.10g}Hz-{variant}.{suffix}"
