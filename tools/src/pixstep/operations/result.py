# SPDX-License-Identifier: MIT
"""What an operation gives back: data, a page of text, and whether all is well."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from pixstep.errors import FINE

Data = Mapping[str, Any]


class Page(Protocol):
    """What a page is written on."""

    def tell(self, text: str) -> None:
        """Write a line."""

    def draw(self, what: Any, *, wide: bool = False, **how: Any) -> None:
        """Write a table or another thing of rich's as its console prints it.

        `wide` if there are sentences in a table.
        """


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
        lines = Lines()
        self.text(lines)
        return "\n".join(lines.rows)

    def __repr__(self) -> str:
        first = self.page().partition("\n")[0]
        return f"<Result {first[:100]!r}, status {self.status}>"


class Lines:
    """A page that is kept as rows of text."""

    def __init__(self) -> None:
        self.rows: list[str] = []

    def tell(self, text: str) -> None:
        """Keep a line."""
        self.rows.append(text)

    def draw(self, what: Any, *, wide: bool = False, **how: Any) -> None:
        """Keep what rich's console prints of something."""
        from rich.console import Console

        console = Console(width=120 if wide else 100, highlight=False, color_system=None)
        with console.capture() as captured:
            console.print(what, **{"markup": False, **how})
        self.rows += captured.get().splitlines()
