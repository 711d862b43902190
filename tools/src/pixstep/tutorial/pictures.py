# SPDX-License-Identifier: MIT
"""Whether two pictures show the same."""

from pathlib import Path

import matplotlib.image
import numpy as np

MAX_BYTES = 150_000
# Letters of another release of the font library differ at their rims; a moved curve or another
# figure differs by more.
_SHADES = 64 / 255
_SHARE = 0.001


def difference(shown: Path, made: Path) -> str:
    """Return in words how two pictures differ, empty if they show the same."""
    for path in (shown, made):
        if not path.is_file():
            return f"{path.name}: missing"
    first, second = (_pixels(path) for path in (shown, made))
    if first.shape != second.shape:
        return f"{_size(first)} pixels, made anew {_size(second)}"
    share = float(np.mean(np.abs(first - second).max(axis=2) > _SHADES))
    return f"{100 * share:.2f} % of its pixels differ from what is made" if share > _SHARE else ""


def _pixels(path: Path) -> np.ndarray:
    """Return height x width x 3 values from 0 to 1."""
    return matplotlib.image.imread(path)[..., :3].astype(float)


def _size(pixels: np.ndarray) -> str:
    return f"{pixels.shape[1]} x {pixels.shape[0]}"
