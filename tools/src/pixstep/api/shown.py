# SPDX-License-Identifier: MIT
"""What results have in common: how they are shown, times in ticks, refusals with findings."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

from pixstep.errors import RefusedError, UserError
from pixstep.lines.line_check import Finding
from pixstep.lines.units import ticks_text


class LineRefusedError(RefusedError):
    """A check refuses a line; `findings` are its errors, each with name and pixel."""

    def __init__(self, message: str, findings: tuple[Finding, ...] = ()) -> None:
        super().__init__(message)
        self.findings: tuple[Finding, ...] = findings
        """The errors of the check."""


@dataclass(frozen=True)
class Ticks:
    """A time in ticks of the board's timer; `print` shows nanoseconds beside it."""

    ticks: float
    """Timer ticks."""
    tick_hz: int
    """Ticks a second."""

    @property
    def ns(self) -> float:
        """The time in nanoseconds."""
        return self.ticks / self.tick_hz * 1e9

    def __str__(self) -> str:
        if math.isnan(self.ticks):
            return "unknown"
        return f"{ticks_text(self.ticks)} ticks ({self.ns:.1f} ns)"


Facts = Iterable[tuple[str, object]]


class Shown:
    """A result that says what it is in one line, and in a notebook by a small table."""

    def _headline(self) -> str:
        """Return what it is in one line, without the name of its class."""
        raise NotImplementedError

    def _facts(self) -> Facts:
        """Yield what a notebook shows of it, each with its name."""
        return ()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._headline()}>"

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        title = f"<b>{type(self).__name__}</b> {escape(self._headline())}"
        rows = "".join(
            f"<tr><td>{escape(name)}</td><td>{escape(str(value))}</td></tr>"
            for name, value in self._facts()
        )
        return f"<div>{title}{f'<table>{rows}</table>' if rows else ''}</div>"


def count(number: int, word: str) -> str:
    """Return a number of things: "1 axis", "1,200 pixels"."""
    plural = "axes" if word == "axis" else f"{word}s"
    return f"{number:,} {word if number == 1 else plural}"


def frame(columns: Mapping[str, Any]) -> Any:
    """Return a pandas.DataFrame, or a pyarrow.Table where there is no pandas."""
    try:
        import pandas
    except ImportError:
        pass
    else:
        return pandas.DataFrame(dict(columns))
    try:
        import pyarrow
    except ImportError:
        raise UserError(
            "to_dataframe: needs pandas or pyarrow: `pip install pandas` in this environment"
        ) from None
    return pyarrow.table(dict(columns))
