# SPDX-License-Identifier: MIT
"""What a profile file was made for: its motor by the conventional name, its pixel frequency.

A conventional name is AccProf<motor>-<f>Hz-<variant>.PRN. A motor may have any name that a file's
name can hold. Of those of the printer, M and two digits, M39 is smooth and the others are plain;
how another one decodes says its machine file.

Counts and speeds in a file are per pixel. At k times the frequency the same file has k times the
speed per second and k^2 times the acceleration: slower is safe for the motor and worth a warning,
faster by more than FASTER is another motion than the file's maker meant.

The backlash that a line was made with, beside the one that it is asked to take up.

A line file whose header has it is for that backlash: its counts leave room for the take-up, and a
machine file that says another one today does not change them. What the caller says comes first all
the same, and every difference is said.
"""

from __future__ import annotations

import re
import time
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from pixstep.errors import AskedText, RefusedError, UserError
from pixstep.formats import ProfileHeader
from pixstep.formats.header import NAME_WIDTH
from pixstep.lines.line import PLAIN, SMOOTH
from pixstep.lines.units import parse_hz


@dataclass(frozen=True)
class AskedBacklash:
    """A backlash in steps, and who says it: the caller, a machine file by its name, or nobody."""

    steps: int
    given: bool = False
    machine: str = ""


def taken(
    name: str, header: ProfileHeader | None, counts: Sequence[int], decode: str,
    asked: AskedBacklash,
) -> tuple[int, list[str]]:  # fmt: skip
    """Return the backlash that a line takes up, and what it says otherwise, or does not say."""
    if decode != SMOOTH:
        return asked.steps, []
    own = header.backlash if header else None
    if own is None:
        unsaid = not asked.given and _has_room(counts)
        return asked.steps, [_unsaid(name, asked)] if unsaid else []
    if asked.given:
        text = f"{name}: made for a backlash of {own} steps, {asked.steps} is taken as asked"
        return asked.steps, [text] if own != asked.steps else []
    text = f"{name}: its own backlash of {own} steps is taken; {asked.machine} has {asked.steps}"
    return own, [text] if asked.machine and own != asked.steps else []


def _has_room(counts: Sequence[int]) -> bool:
    """True if a line begins and ends as those do that take play up."""
    return len(counts) > 2 and not counts[0] and not counts[-1] and any(counts)


def _unsaid(name: str, asked: AskedBacklash) -> str:
    """Return that a line has room for a take-up and does not say of how many steps."""
    if asked.machine:
        return (
            f"{name}: does not say the backlash that it was made for: the {asked.steps} steps of "
            f"{asked.machine} are taken"
        )
    return (
        f"{name}: begins and ends without steps, as lines do that take up backlash, and does not "
        f"say how much: none is taken up"
    )


SMOOTH_MOTORS = ("M39",)
_STEM = r"AccProf(.+)-(\d+(?:\.\d+)?)Hz-(\w+)"
_FILE_NAME = re.compile(rf"{_STEM}\.(?:PRN|CSV|CSB)", re.IGNORECASE)
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


def parse_name(path: Path) -> ProfileName | None:
    """Return what the name of a file says, None if it is not a conventional one."""
    found = _FILE_NAME.fullmatch(path.name)
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
    named = parse_name(path)
    return named.motor if named else None


def other_motor(path: Path, header_name: str | None, motor: str) -> list[str]:
    """Return a note of a file that is for another motor than the one it is used for."""
    made_for = motor_of(path, header_name)
    if made_for in (None, motor):
        return []
    return [f"{path}: made for motor {made_for}, used for motor {motor}"]


def _motor(name: str) -> str:
    return name.upper() if _OF_PRINTER.fullmatch(name) else name


def conventional_name(motor: str, hz: Fraction, variant: str, suffix: str = "PRN") -> str:
    """Return the conventional name. Raises UserError for a motor or variant that does not fit."""
    if not motor or _NO_NAME.search(motor):
        raise UserError(f"motor {motor!r}: its name cannot be a part of a file's name")
    if not re.fullmatch(r"\w+", variant):
        raise UserError(f"variant {variant!r}: expected letters, digits or underscores")
    return f"AccProf{motor}-{float(hz):.10g}Hz-{variant}.{suffix}"


FASTER = Fraction(1, 100)
MOST_EDGES = 1000  # of the clock in a pixel: the range of the board's setting `divider`


@dataclass(frozen=True)
class OtherFrequency:
    """A file that is used at another pixel frequency than it was made for."""

    source: str
    made_for: Fraction
    used: Fraction
    by_name: bool = False
    divider: int = 1  # clock edges of a pixel

    @property
    def too_fast(self) -> bool:
        """True if the motion is another one than that of the file."""
        return self.used > self.made_for * (1 + FASTER)

    @property
    def text(self) -> str:
        """The difference and what it does, without the file."""
        made, used = (f"{float(hz):.10g}" for hz in (self.made_for, self.used))
        if made == used:
            made, used = str(self.made_for), str(self.used)
        ratio = float((self.used / self.made_for) ** 2)
        return (
            f"made for {made} Hz, used at {used} Hz: its accelerations per second are "
            f"{ratio:.4g} times as high"
        )

    @property
    def remedy(self) -> AskedText:
        """What to do if the other frequency is meant."""
        change = "rename it" if self.by_name else "give it this frequency by `pixstep file convert`"
        text = f"make one for this frequency, or {change} if the higher accelerations are meant"
        edges = round(self.used * self.divider / self.made_for)
        if 1 < edges <= MOST_EDGES and is_same(self.made_for, self.used * self.divider / edges):
            text += f"; or {{divider}} {edges}, not {self.divider}, if it is for this clock"
        return AskedText(text)

    def refuse_faster(self) -> str:
        """Return the warning. Raises RefusedError if the motion is another one."""
        if self.too_fast:
            raise RefusedError(AskedText(
                "{source}: {text}: {remedy}", source=self.source, text=self.text, remedy=self.remedy
            ))  # fmt: skip
        return f"{self.source}: {self.text}"


def header(name: str, lead_in: int, hz: Fraction, backlash: int | None = None) -> ProfileHeader:
    """Return a header stamped now. Raises UserError for a name that is too long for it."""
    if len(name) > NAME_WIDTH:
        raise UserError(f"header name {name!r} is longer than {NAME_WIDTH} characters")
    return ProfileHeader(time.ctime(), name, 1, 0, lead_in, f"{float(hz):.10g}", backlash)


def of_pixels(
    path: Path, lead_in: int, hz: Fraction, divider: int, backlash: int | None = None
) -> ProfileHeader | None:
    """Return the header by which a line holds its user to its divider and its backlash.

    None if that is 1 and this 0: lines that take no play up begin with steps.
    """
    if divider == 1 and not backlash:
        return None
    return header(plain_name(path), lead_in, hz, backlash)


def plain_name(path: Path) -> str:
    """Return the name that a header gets from its file's."""
    name = "".join(sign if " " <= sign <= "~" else "_" for sign in path.stem[:NAME_WIDTH])
    return name.strip()


def frequency_of(path: Path, header: ProfileHeader | None) -> Fraction | None:
    """Return the frequency of a file's header, else of its conventional name, else None."""
    if header is not None:
        return header.frequency
    named = parse_name(path)
    return named.pixel_hz if named else None


def is_same(written: Fraction, used: Fraction) -> bool:
    """True if a frequency is the one used, as far as the digits of a header say."""
    return written in (used, Fraction(f"{float(used):.10g}"))


def frequency_notes(
    path: Path,
    header: ProfileHeader | None,
    used: Fraction | None,
    *,
    refuse: bool = False,
    divider: int = 1,
) -> list[str]:
    """Return a warning if the frequencies differ; RefusedError for a faster one on `refuse`.

    The frequencies are those of pixels, `used` is that of a clock by `divider`. A file that does
    not say its own gets a note where a pixel is more than an edge of the clock.
    """
    made_for = frequency_of(path, header)
    if used is None or (made_for is not None and is_same(made_for, used)):
        return []
    if made_for is None:
        text = f"no header says how long its pixels are: each is taken as {divider} edges of the"
        return [f"{path}: {text} clock"] if divider > 1 else []
    other = OtherFrequency(str(path), made_for, used, header is None, divider)
    return [other.refuse_faster() if refuse else f"{other.source}: {other.text}"]
