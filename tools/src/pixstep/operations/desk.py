# SPDX-License-Identifier: MIT
"""What an operation has besides its request: the machine in force, and somebody to tell."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

from pixstep.errors import FINE
from pixstep.operations.facts import Facts
from pixstep.operations.result import Data, Result
from pixstep.progress import Progress, unseen

if TYPE_CHECKING:
    from pixstep.board.link import Link

Shown = Callable[[str], contextlib.AbstractContextManager[Progress]]


class Source(Enum):
    """Where a value of a request comes from."""

    CALLER = "caller"
    MACHINE = "machine"
    DEFAULT = "default"


@contextlib.contextmanager
def nobody_watches(title: str) -> Iterator[Progress]:
    """Show no progress."""
    del title
    yield unseen


@dataclass
class Desk:
    """What an operation has besides its request.

    `say` takes notes and `warn` warnings; `tell` takes a line of a page that grows while the
    operation runs; `progress` shows how far something long is.
    """

    facts: Facts
    sources: dict[str, Source] = field(default_factory=dict)
    say: Callable[[Iterable[str]], None] = lambda notes: None
    tell: Callable[[str], None] = lambda text: None
    warn: Callable[[Iterable[str]], None] = lambda warnings: None
    complain: Callable[[Exception], None] = lambda error: None
    row: Callable[[Data], None] = lambda data: None
    progress: Shown = nobody_watches
    link: Link | None = None  # a bus that the caller has open
    so_far: Result | None = None  # what there is to give back if the operation fails

    def rows(self, key: str = "boards") -> Rows:
        """Return what takes rows of the result as they come; they are given back in any case."""
        return Rows(self, key)

    def given(self, name: str) -> bool:
        """True if the caller says a value, and it is not only in the machine file."""
        return self.sources.get(name) is Source.CALLER

    def by_machine(self, name: str) -> bool:
        """True if the machine file gave a value."""
        return self.sources.get(name) is Source.MACHINE


class Rows:
    """Rows of a result, each told when it comes; those so far are what a failure leaves."""

    def __init__(self, desk: Desk, key: str):
        self._desk, self._key = desk, key
        self._rows: list[Data] = []
        self._texts: list[str] = []
        desk.so_far = self.result()

    def add(self, data: Data, text: str) -> None:
        """Add a row."""
        self._rows.append(data)
        self._texts.append(text)
        self._desk.tell(text)

    def result(self, status: int = FINE) -> Result:
        """Return all rows as a result."""
        return Result({self._key: self._rows}, "\n".join(self._texts), status, told=True)
