# SPDX-License-Identifier: MIT
"""What an operation has besides its request: the machine in force, and somebody to tell."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Any

from pixstep.errors import FINE
from pixstep.operations.facts import Facts
from pixstep.operations.result import Data, Result
from pixstep.progress import Progress, unseen

if TYPE_CHECKING:
    from pixstep.board.link import Link
    from pixstep.server.journal import Log


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
    operation runs, `aside` one that is no part of it; `progress` shows how far something long is.
    `view` is what a front end has for one operation alone: a person to ask, a screen to draw on.
    A caller that `keeps` wants all rows in the result, also of what may go on for days.
    """

    facts: Facts
    sources: dict[str, Source] = field(default_factory=dict)
    say: Callable[[Iterable[str]], None] = lambda notes: None
    tell: Callable[[str], None] = lambda text: None
    aside: Callable[[str], None] = lambda text: None
    warn: Callable[[Iterable[str]], None] = lambda warnings: None
    complain: Callable[[Exception], None] = lambda error: None
    row: Callable[[Data], None] = lambda data: None
    progress: Shown = nobody_watches
    view: Any = None
    keeps: bool = True
    link: Link | None = None  # a bus that the caller has open
    so_far: Result | None = None  # what there is to give back if the operation fails

    def rows(self, key: str = "boards", beside: Data | None = None) -> ResultRows:
        """Return what takes rows of the result as they come; they are given back in any case.

        `beside` is the result's other data.
        """
        return ResultRows(self, key, beside or {})

    def given(self, name: str) -> bool:
        """True if the caller says a value, and it is not only in the machine file."""
        return self.sources.get(name) is Source.CALLER

    def by_machine(self, name: str) -> bool:
        """True if the machine file gave a value."""
        return self.sources.get(name) is Source.MACHINE


class ResultRows:
    """Rows of a result, each told when it comes; those so far are what a failure leaves."""

    def __init__(self, desk: Desk, key: str, beside: Data):
        self._desk, self._key, self._beside = desk, key, beside
        self._rows: list[Data] = []
        self._texts: list[str] = []
        desk.so_far = self.result()

    def add(self, data: Data, text: str) -> None:
        """Add a row."""
        self._rows.append(data)
        self.tell(text)

    def tell(self, text: str) -> None:
        """Add a text without data of its own."""
        self._texts.append(text)
        self._desk.tell(text)

    def result(self, status: int = FINE) -> Result:
        """Return all rows as a result."""
        return Result(
            {**self._beside, self._key: self._rows}, "\n".join(self._texts), status, told=True
        )


def log_of(desk: Desk) -> Log:
    """Return where a server tells what happens."""
    return desk.view() if desk.view else _Noted(desk)


class _Noted:
    """The log of a server that a program runs: its notes."""

    def __init__(self, desk: Desk):
        self._desk = desk

    def tell(self, event: str, **facts: Any) -> None:
        """Note what has happened."""
        self._desk.say((f"{event}: {', '.join(f'{key} {facts[key]}' for key in facts)}",))

    def close(self) -> None:
        """Keep what was noted."""
