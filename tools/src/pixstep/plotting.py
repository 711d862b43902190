# SPDX-License-Identifier: MIT
"""How every figure looks, how it is made and written.

Figures are made without pyplot: it keeps a list of figures and chooses a backend for the whole
process, both of which belong to the program that imports this package.
"""

import contextlib
import io
import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, Protocol

from pixstep import atomic
from pixstep.lazy import missing_package

try:
    import matplotlib as mpl
except ModuleNotFoundError as missing:
    raise missing_package(missing) or missing from None
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import Formatter, MaxNLocator, ScalarFormatter

INK = "#22303c"
FAINT = "#8795a1"  # lines that only lead the eye; no text
QUIET = "#53626e"  # text that is second to INK
IDEAL = "#f2a541"  # broad and pale, below a curve
WARM = "#9c5a00"  # a curve or dots of the same meaning, where they are thin
MADE = "#1f6f8b"
BOARD = "#b8452e"
BAND = "#e8f1f2"

THIN_SPACE, MINUS = "\u2009", "\u2212"
_MOST_DECIMALS = 9
_TICKS_PER_INCH = 0.9  # of the seconds, whose texts are long
_PREFIXES = ((1e-9, "n"), (1e-6, "µ"), (1e-3, "m"), (1.0, ""))
_SECONDS_BELOW = 38  # points below the axis of the pixels, which has its own label

STYLE: dict[Any, Any] = {
    "figure.dpi": 110,
    "savefig.dpi": 130,
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
    "axes.axisbelow": True,
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
    made.text(0.012, place, below, fontsize=9.5, color=QUIET, va="top")


def number(value: float, decimals: int = 0) -> str:
    """Return a number as all figures write it: thin spaces between thousands, a real minus."""
    rounded = round(value, decimals) + 0.0  # no minus zero
    return f"{rounded:,.{decimals}f}".replace(",", THIN_SPACE).replace("-", MINUS)


class Numbers(Formatter):
    """Ticks as `number` writes them, all with the decimals that the finest of them needs."""

    def __call__(self, value: float, pos: int | None = None) -> str:
        del pos
        return number(value, _decimals((value,)))

    def format_ticks(self, values: Sequence[float]) -> list[str]:
        """Return the texts of all ticks of an axis."""
        decimals = _decimals(values)
        return [number(value, decimals) for value in values]


def _decimals(places: Sequence[float]) -> int:
    """Return how many decimals tell the places of ticks apart."""
    step = min((abs(after - before) for before, after in pairwise(places)), default=1.0)
    rounded = (
        decimals
        for decimals in range(_MOST_DECIMALS)
        if all(abs(round(place, decimals) - place) <= step / 1000 for place in places)
    )
    return next(rounded, _MOST_DECIMALS)


def write_numbers(made: Figure) -> Figure:
    """Give all linear axes of a figure, insets and second scales too, their ticks; return it."""
    for axis in made.findobj(Axis):
        if type(axis.get_major_formatter()) is ScalarFormatter:
            axis.set_major_formatter(Numbers())
    return made


def time_axis(axes: Axes, hz: Fraction | float | None, origin: str = "line zero") -> None:
    """Label the time of a figure: pixels, and below them seconds if the frequency is known."""
    axes.set_xlabel(f"pixels after {origin}")
    if hz is None:
        return
    rate = float(hz)
    functions = (lambda pixels: np.divide(pixels, rate), lambda time: np.multiply(time, rate))
    seconds = axes.secondary_xaxis("bottom", functions=functions)
    seconds.spines["bottom"].set_position(("outward", _SECONDS_BELOW))
    seconds.set_xlabel(f"seconds after {origin}")
    whole = axes.get_figure(root=True)
    width = axes.get_position().width * (whole.get_figwidth() if whole else 1)
    seconds.xaxis.set_major_locator(
        MaxNLocator(max(4, round(_TICKS_PER_INCH * width)), steps=[1, 2, 2.5, 5, 10])
    )


class LengthScale(Protocol):
    """How many steps are a millimetre or a degree, as `lines.units.Scale` says it."""

    @property
    def steps_per_unit(self) -> Fraction:
        """Steps of a unit of length."""

    @property
    def length(self) -> str:
        """The unit: mm or deg."""


def lengths(axes: Axes, scale: LengthScale | None, per: str = "", factor: float = 1.0) -> None:
    """Put lengths on the right of an axis in steps, where a motor's scale is known.

    They are in nm, µm, mm or m, as the axis' ends need it; `factor` makes the axis' unit steps
    `per` what the unit of length is to be per: "/s".
    """
    if scale is None:
        return
    ratio = factor / float(scale.steps_per_unit)
    unit = scale.length
    if unit == "mm":
        most = max(abs(end) for end in axes.get_ylim()) * ratio / 1000
        ratio, unit = ratio / 1000 / prefix(most)[0], f"{prefix(most)[1]}m"
    functions = (lambda steps: np.multiply(steps, ratio), lambda made: np.divide(made, ratio))
    beside = axes.secondary_yaxis("right", functions=functions)
    beside.set_ylabel(f"{unit}{per}")
    beside.spines["right"].set_visible(True)
    beside.spines["right"].set_color("#dfe5ea")


def prefix(most: float) -> tuple[float, str]:
    """Return the prefix of a unit, and its size, by which figures up to `most` are read best."""
    return next((one for one in reversed(_PREFIXES) if most >= one[0]), _PREFIXES[0])


def figures(value: float, digits: int = 3) -> str:
    """Return a figure with so many digits that count, without an exponent; large ones whole."""
    if not value:
        return "0"
    decimals = digits - 1 - math.floor(math.log10(abs(value)))
    return number(value, max(0, decimals))


def shade(axes: Axes, spans: list[tuple[int, int]]) -> None:
    """Shade transitions, given as (first, last) 1-based pixels."""
    for first, last in spans:
        axes.axvspan(first - 1, last, color=BOARD, alpha=0.13, lw=0, zorder=0)


def write(made: Figure, path: Path, **options: Any) -> Path:
    """Write a figure in the format of the suffix, whole or not at all; return the path."""
    atomic.write_with(path, partial(made.savefig, **options))
    return path
