# SPDX-License-Identifier: MIT
"""What a motor makes in a line: its shape, which many lines share, and where and which way it runs.

A shape is everything that decides the edges: counts, how they are decoded, the play that is taken
up. With it goes the table of expected positions, which is computed once.
"""

from __future__ import annotations

import hashlib
import struct
from array import array
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from pixstep.lines import exact
from pixstep.lines.line import PLAIN, SMOOTH, Line

KEY_BYTES = 16
IMAGE, RETURN = "image", "return"
PLUS, MINUS, NONE = "+", "-", ""


@dataclass(frozen=True)
class Shape:
    """Counts per pixel, how they are decoded, and the play in steps that is taken up.

    `expected` are the positions at the pixels' end edges, in steps from the line's start, of a line
    in the positive direction.
    """

    counts: tuple[int, ...]
    decode: str
    backlash: int
    expected: tuple[int, ...]

    @classmethod
    def of(cls, counts: Iterable[int], decode: str, backlash: int = 0) -> Shape:
        """Return a shape with the exact table of its positions."""
        line = Line(tuple(counts), decode, backlash if decode == SMOOTH else 0)
        return cls(line.counts, decode, line.backlash, tuple(exact.expected_positions(line)))

    @cached_property
    def key(self) -> bytes:
        """The first bytes of the SHA-256 of what decides its edges."""
        return key_of(self.counts, self.decode, self.backlash)

    def line(self, *, negative: bool = False, name: str = "line") -> Line:
        """Return a line of this shape; a plain one that is negative has its counts turned round."""
        turned = negative and self.decode == PLAIN
        counts = tuple(-count for count in self.counts) if turned else self.counts
        return Line(counts, self.decode, self.backlash, negative and not turned, name=name)

    @property
    def travel(self) -> int:
        """Where the motor is at the end, in steps from the line's start."""
        return self.expected[-1] if self.expected else 0


def key_of(counts: Iterable[int], decode: str, backlash: int) -> bytes:
    """Return the key of a shape."""
    content = hashlib.sha256(f"{decode} {backlash}\n".encode())
    values = array("i", counts)
    content.update(struct.pack(f"<{len(values)}i", *values))
    return content.digest()[:KEY_BYTES]


@dataclass(frozen=True, slots=True)
class MotorRun:
    """What one motor does in one line.

    `start_steps` is where the motor is at line zero, `play_side` the direction in which it moved
    last before; `image_pixel` is the first one of the image, from 1, 0 for a line without one.
    """

    line: int
    motor: str
    shape: bytes
    negative: bool = False
    start_steps: int = 0
    play_side: str = NONE
    image_pixel: int = 0
    pixels: int = 0
    purpose: str = IMAGE
