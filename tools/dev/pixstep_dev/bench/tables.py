# SPDX-License-Identifier: MIT
"""The figures as tables: on a terminal and as Markdown."""

from collections.abc import Iterable, Sequence
from typing import Any

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from pixstep_dev.bench.figure import BenchFigure, FigureColumn


def markdown(figures: Iterable[BenchFigure], measured: dict[str, Any]) -> str:
    """Return all measured figures as Markdown."""
    parts = []
    for figure in figures:
        rows = measured["figures"].get(figure.name)
        if rows:
            table = pipes(figure.columns, figure.merge(rows))
            parts.append(f"### {figure.title}\n\n{figure.about}\n\n{table}")
    return "\n\n".join(parts) + "\n"


def pipes(columns: Sequence[FigureColumn], rows: list[dict[str, Any]]) -> str:
    """Return rows as a Markdown table."""
    lines = [[column.head for column in columns]]
    lines.append(["---" if column.left else "--:" for column in columns])
    lines += [[column.text(row).replace("|", "/") for column in columns] for row in rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def show(console: Console, figures: Iterable[BenchFigure], measured: dict[str, Any]) -> None:
    """Print all measured figures, and what must never be if it was."""
    for figure in figures:
        rows = measured["figures"].get(figure.name)
        if rows:
            console.print(Text(figure.title, style="bold"))
            console.print(Text(figure.about, style="dim"))
            console.print(grid(figure.columns, figure.merge(rows)))
    for text in measured["not_measured"]:
        console.print(Text(f"not measured: {text}", style="yellow"))
    for text in measured["failures"]:
        console.print(Text(f"WRONG EDGES: {text}", style="bold red"))


def grid(columns: Sequence[FigureColumn], rows: list[dict[str, Any]]) -> Table:
    """Return rows as a table for a terminal."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    cells = [[column.text(row) for column in columns] for row in rows]
    for index, column in enumerate(columns):
        longest_word = max((len(word) for row in cells for word in row[index].split()), default=0)
        table.add_column(
            Text(column.head),
            justify="left" if column.left else "right",
            min_width=longest_word,
            overflow="fold",
        )
    for row in cells:
        table.add_row(*map(Text, row))
    return table
