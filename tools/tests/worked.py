# SPDX-License-Identifier: MIT
"""The worked example and its golden numbers, shared by the tests."""

from pathlib import Path

from pixstep import formats
from pixstep.lines.line import Line
from pixstep.profiles import generator

DATA = Path(__file__).resolve().parent.parent / "data"
PRN = DATA / "AccProfM39-30Hz-1.PRN"
MPOS = DATA / "mpos-worked-example.csv"
SAMPLE_CSV = DATA / "AccProf-sample.csv"

ACCELERATING = [4, 12, 20, 28, 35, 41, 86, 150, 214, 320, 448, 576, 704, 832, 948]

_WITHOUT = [4, 16, 36, 64, 99, 140, 226, 376, 590, 910, 1358, 1934, 2638, 3470, 4418, 5418, 6418]
_B250 = [0, 6, 20, 42, 72, 108, 153, 259, 421, 658, 1010, 1490, 2098, 2834, 3697, 4668, 5668]

# Steps made at the end edges of pixels 1..17, by backlash.
EXPECTED = {0: _WITHOUT, 250: _B250, 1000: _WITHOUT}


def worked_line(backlash: int, pixels: int = 60, speed: int = 1000) -> Line:
    """Return the worked example: 30 Hz profile, the given backlash and speed."""
    speeds, _ = formats.read_prn(PRN)
    made = generator.generate(speeds, generator.LineRequest(speed, pixels, backlash))
    return Line(tuple(made.counts), backlash=backlash, name="worked example")
