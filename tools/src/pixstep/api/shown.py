# SPDX-License-Identifier: MIT
"""Results as a notebook shows them, and as tables of pandas or Arrow."""

from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

from pixstep.errors import UserError

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
