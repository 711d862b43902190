# SPDX-License-Identifier: MIT
"""How every figure looks, how it is made and written.

Figures are made without pyplot: it keeps a list of figures and chooses a backend for the whole
process, both of which belong to the program that imports this package.
"""

import contextlib
import io
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from pixstep import atomic

INK = "#22303c"
FAINT = "#8795a1"
IDEAL = "#f2a541"
MADE = "#1f6f8b"
BOARD = "#c8553d"
BAND = "#e8f1f2"

STYLE: dict[Any, Any] = {
    "figure.dpi": 110,
    "savefig.dpi": 140,
    "font.size": 10,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dfe5ea",
    "grid.linewidth": 0.6,
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
}


@contextlib.contextmanager
def styled(**more: Any) -> Iterator[None]:
    """Make and write figures in this style as long as this lasts."""
    with mpl.rc_context(STYLE | more):
        yield


class Drawing(Figure):
    """A figure that a notebook shows as a picture, though pyplot does not know it."""

    def _repr_png_(self) -> bytes:
        data = io.BytesIO()
        with styled():
            self.savefig(data, format="png", dpi=100)
        return data.getvalue()


def figure(size: tuple[float, float]) -> Figure:
    """Return an empty figure, `size` in inches."""
    made = Drawing(figsize=size, layout="constrained")
    FigureCanvasAgg(made)
    return made


def heading(made: Figure, title: str, below: str, place: float = 0.948) -> None:
    """Write the title of a figure, and what was drawn below it at `place` (1 is the top)."""
    made.suptitle(f"{title}\n", x=0.012, ha="left", fontsize=14, weight="bold", color=INK)
    made.text(0.012, place, below, fontsize=9.5, color=FAINT, va="top")


def shade(axes: Axes, spans: list[tuple[int, int]]) -> None:
    """Shade transitions, given as (first, last) 1-based pixels."""
    for first, last in spans:
        axes.axvspan(first - 1, last, color=BOARD, alpha=0.13, lw=0, zorder=0)


def write(made: Figure, path: Path, **options: Any) -> Path:
    """Write a figure in the format of the suffix, whole or not at all; return the path."""
    atomic.write_with(path, partial(made.savefig, **options))
    return path
