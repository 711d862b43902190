# SPDX-License-Identifier: MIT
"""What a figure is: tasks that can run side by side, and a table of the rows they return."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

Rows = list[dict[str, Any]]


@dataclass(frozen=True)
class Task:
    """One independent piece of work: `work(*arguments)` returns rows, plain data each.

    The first argument is the board that is measured. A task is sent to another process, so `work`
    is a function of a module. `alone` is for what other work at the same time would disturb.
    """

    figure: str
    work: Callable[..., list[dict[str, Any]]]
    arguments: tuple[Any, ...]
    alone: bool = False

    @property
    def board(self) -> str:
        """The board that is measured."""
        return str(self.arguments[0])


@dataclass(frozen=True)
class FigureColumn:
    """One column of a table: its head, and the text of a row in it."""

    head: str
    text: Callable[[dict[str, Any]], str]
    left: bool = False


@dataclass(frozen=True)
class BenchFigure:
    """A figure: name on the command line, title, what is measured and how, tasks, table."""

    name: str
    title: str
    about: str
    tasks: Callable[[], list[Task]]
    columns: Sequence[FigureColumn]
    long: bool = False  # a search over many runs
    merge: Callable[[Rows], Rows] = lambda rows: rows  # rows as the table shows them


def key(head: str, name: str, form: str = "", *, left: bool = False) -> FigureColumn:
    """Return the column of one key of a row, formatted; a missing value is a dash."""

    def text(row: dict[str, Any]) -> str:
        value = row.get(name)
        return "-" if value is None else format(value, form)

    return FigureColumn(head, text, left)


def failures(rows: list[dict[str, Any]]) -> list[str]:
    """Return what rows found that must never be: edges that were wrong without a fault."""
    return [text for row in rows for text in row.get("wrong", ())]
