# SPDX-License-Identifier: MIT
"""Whether two pictures show the same."""

from pathlib import Path

import matplotlib.image
import numpy as np

MAX_BYTES = 150_000
# Letters of another release of the font library differ at their rims, and what a board does at its
# own time (a leg of homing begins a few milliseconds sooner or later) moves a curve by a pixel or
# two; another curve, figure or label differs by more.
_SHADES = 64 / 255
_SHARE = 0.001
_HAIR_PX = 2


def difference(shown: Path, made: Path) -> str:
    """Return in words how two pictures differ, empty if they show the same."""
    for path in (shown, made):
        if not path.is_file():
            return f"{path.name}: missing"
    first, second = (_pixels(path) for path in (shown, made))
    if first.shape != second.shape:
        return f"{_size(first)} pixels, made anew {_size(second)}"
    share = max(_unlike(first, second), _unlike(second, first))
    return f"{100 * share:.2f} % of its pixels differ from what is made" if share > _SHARE else ""


def _unlike(first: np.ndarray, second: np.ndarray) -> float:
    """Return the share of the pixels of `first` that have none of their colour near in `second`."""
    rows, columns = np.nonzero(np.abs(first - second).max(axis=2) > _SHADES)
    framed = np.pad(second, ((_HAIR_PX,) * 2, (_HAIR_PX,) * 2, (0, 0)), mode="edge")
    wanted = first[rows, columns]
    least = np.full(len(rows), np.inf)
    for down in range(2 * _HAIR_PX + 1):
        for right in range(2 * _HAIR_PX + 1):
            near = framed[rows + down, columns + right]
            least = np.minimum(least, np.abs(wanted - near).max(axis=1))
    return float(np.count_nonzero(least > _SHADES) / first[..., 0].size)


def _pixels(path: Path) -> np.ndarray:
    """Return height x width x 3 values from 0 to 1."""
    return matplotlib.image.imread(path)[..., :3].astype(np.float32)


def _size(pixels: np.ndarray) -> str:
    return f"{pixels.shape[1]} x {pixels.shape[0]}"
