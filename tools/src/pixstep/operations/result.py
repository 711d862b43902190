# SPDX-License-Identifier: MIT
"""What an operation gives back: data, a page of text, and whether all is well."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from pixstep.errors import FINE, NEGATIVE, REFUSED

Data = Mapping[str, Any]
VERDICTS = ("fine", "warnings", "refused")  # of a check, by its severity
STATUSES = (FINE, NEGATIVE, REFUSED)  # of these verdicts


class Page(Protocol):
    """What a page is written on."""

    def tell(self, text: str) -> None:
        """Write a line."""

    def draw(self, what: Any, *, wide: bool = False) -> None:
        """Write a table or another thing of rich's; `wide` if there are sentences in a table."""

    def print(
        self, what: Any, /, *, style: str | None = None, markup: bool | None = None,
        highlight: bool | None = None, soft_wrap: bool | None = None,
    ) -> None:  # fmt: skip
        """Write something as rich's console prints it."""

    def styled(self, text: str, *, colour: str | None = None, bold: bool | None = None) -> str:
        """Return a text in a colour, or bold, where the page can show that."""


Writer = Callable[[Page], None]


@dataclass(frozen=True, repr=False)
class Result:
    """What an operation gives back.

    `data` is as the operation's `result` type says, and nothing but plain data; `text` is the page,
    or what writes it; `status` is 0 if all is well, 1 for a negative verdict, 3 for a refusal;
    `value` is what Python may go on with; `notes` are what was said on the way; a
    page that was `told` grew while the operation ran.
    """

    data: Data
    text: str | Writer = field(default="", compare=False)
    status: int = FINE
    value: Any = field(default=None, compare=False)
    notes: tuple[str, ...] = field(default=(), compare=False)
    told: bool = field(default=False, compare=False)  # the page was told row by row

    def to_dict(self) -> dict[str, Any]:
        """Return the data."""
        return dict(self.data)

    def __getitem__(self, key: str) -> Any:
        return self.data[key]

    @property
    def fine(self) -> bool:
        """True if all is well."""
        return self.status == FINE

    def page(self) -> str:
        """Return the page as text."""
        if isinstance(self.text, str):
            return self.text
        lines = TextPage()
        self.text(lines)
        return "\n".join(lines.rows)

    def __getstate__(self) -> dict[str, Any]:
        """Return what is pickled: the page as it is, instead of what writes it."""
        return {**self.__dict__, "text": self.page()}

    def __repr__(self) -> str:
        first = next(filter(str.strip, self.page().splitlines()), "").strip()
        return f"<Result {first[:100]!r}, status {self.status}>"


class TextPage:
    """A page that is kept as rows of text."""

    def __init__(self) -> None:
        self.rows: list[str] = []

    def tell(self, text: str) -> None:
        """Keep a line."""
        self.rows.append(text)

    def styled(self, text: str, *, colour: str | None = None, bold: bool | None = None) -> str:
        """Return the text as it is."""
        del colour, bold
        return text

    def draw(self, what: Any, *, wide: bool = False) -> None:
        """Keep a table or another thing of rich's."""
        self._keep(120 if wide else 100, what, markup=False)

    def print(self, what: Any, /, **how: Any) -> None:
        """Keep what rich's console prints of something."""
        self._keep(100, what, **how)

    def _keep(self, width: int, what: Any, **how: Any) -> None:
        from rich.console import Console

        console = Console(width=width, highlight=False, color_system=None)
        with console.capture() as captured:
            console.print(what, **how)
        self.rows += captured.get().splitlines()
