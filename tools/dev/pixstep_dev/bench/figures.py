# SPDX-License-Identifier: MIT
"""All figures, in the order in which they are shown."""

from pixstep_dev.bench import (
    accuracy,
    clocks,
    decode,
    handlers,
    overload,
    ramp,
    rates,
    share,
    simspeed,
    sizes,
    turns,
    waits,
)
from pixstep_dev.bench.figure import BenchFigure

FIGURES: tuple[BenchFigure, ...] = tuple(
    module.FIGURE
    for module in (
        handlers, decode, rates, clocks, share, ramp, accuracy, overload, waits, turns, sizes,
        simspeed,
    )
)  # fmt: skip
NAMES = tuple(figure.name for figure in FIGURES)


def chosen(only: tuple[str, ...] = (), *, quick: bool = False) -> list[BenchFigure]:
    """Return the figures with these names (none: all); `quick` leaves the long searches out."""
    return [
        figure
        for figure in FIGURES
        if (not only or figure.name in only) and not (quick and figure.long)
    ]
