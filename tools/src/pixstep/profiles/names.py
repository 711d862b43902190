# SPDX-License-Identifier: MIT
"""The conventional names of profile files: AccProf<motor>-<f>Hz-<variant>.PRN."""

import re
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from pixstep.errors import UserError
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.rational import parse_hz

SMOOTH_MOTORS = ("M39",)
_NAME = re.compile(r"AccProf(M\d{2})-(\d+(?:\.\d+)?)Hz-(\w+)\.(?:PRN|CSV|CSB)", re.IGNORECASE)


@dataclass(frozen=True)
class ProfileName:
    """What a conventional name says."""

    motor: str
    pixel_hz: Fraction
    variant: str

    @property
    def decode(self) -> str:
        """How the motor decodes printing lines: smooth or plain."""
        return SMOOTH if self.motor in SMOOTH_MOTORS else PLAIN


def parse(path: Path) -> ProfileName | None:
    """Return what the name of a file says, None if it is not a conventional one."""
    found = _NAME.fullmatch(path.name)
    if not found:
        return None
    return ProfileName(found[1].upper(), parse_hz(found[2]), found[3])


def conventional(motor: str, hz: Fraction, variant: str, suffix: str = "PRN") -> str:
    """Return the conventional name. Raises UserError for a motor or variant that does not fit."""
    if not re.fullmatch(r"M\d{2}", motor):
        raise UserError(f"motor {motor!r}: expected M and two digits, as M39")
    if not re.fullmatch(r"\w+", variant):
        raise UserError(f"variant {variant!r}: expected letters, digits or underscores")
    return f"AccProf{motor}-{float(hz):.10g}Hz-{variant}.{suffix}"
