# SPDX-License-Identifier: MIT
"""All the ways in which a table can be read: one is taken, several are refused.

0,5 is a number or two of them, 1.000 is one or a thousand. So every separator and both marks of
decimals are tried; ways that leave no word where another finds numbers only are kept. Where they
give different numbers the file is refused with what it may mean and the options that choose.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from pixstep.errors import RefusedError, UserError
from pixstep.owndata.columns import INDEX, TIME, ChoiceError, Column, choose, of_table
from pixstep.owndata.layout import SourceText, TableLayout, read_text
from pixstep.owndata.table import (
    BLANK,
    COMMA,
    DECIMALS,
    NONE,
    POINT,
    SEPARATORS,
    STYLES,
    TableFormat,
    TextTable,
    shown,
)

_STRONG = ("semicolon", "tab", "bar")  # these stand in no number
_QUOTED = re.compile(r'"[^"]*"')
_MOST_READINGS = 4  # in a message


@dataclass(frozen=True)
class TableHints:
    """What the user says of a table; None where the file has to say."""

    column: str | None = None
    separator: str | None = None
    decimal: str | None = None


@dataclass(frozen=True)
class TableReading:
    """A table, what its columns hold, and the column to import."""

    table: TextTable
    columns: Sequence[Column]
    column: Column


@dataclass
class _Trial:
    """One way to read the file and what became of it."""

    way: TableFormat
    layout: TableLayout
    table: TextTable | None = None
    words: frozenset[tuple[int, int]] = frozenset()
    reading: TableReading | None = None
    refusal: UserError | None = None
    meaning: object = None  # equal where two ways say the same; None: the file is not like that


def read(path: Path, asked: TableHints) -> TableReading:
    """Read a table in the one way that is possible.

    Raises RefusedError naming the place of what is no table of numbers, or what it may mean.
    """
    text = read_text(path)
    if asked.separator is None and text.separator is None:
        text = _unquoted(text)
    if not text.data:
        raise RefusedError(f"{path}: no numbers in it")
    trials = list(_trials(text, asked))
    meant: dict[object, list[_Trial]] = {}
    for trial in _plausible(trials):
        _try(trial, asked)
        if trial.meaning is not None:
            meant.setdefault(trial.meaning, []).append(trial)
    if len(meant) > 1:
        raise _ambiguous(text, list(meant.values()))
    for trial in next(iter(meant.values()), []):
        if trial.reading:
            return trial.reading
    raise _why(trials)


def _unquoted(text: SourceText) -> SourceText:
    """Return a text whose lines are all in quotes as a whole without these."""
    if not text.data or not all(_QUOTED.fullmatch(line) for _, line in text.data):
        return text
    lines = tuple((number, line.strip('"')) for number, line in text.lines)
    return replace(text, lines=lines)


def _trials(text: SourceText, asked: TableHints) -> Iterator[_Trial]:
    """Yield every way to read a text, the likeliest separator first."""
    separators = _separators(text, asked)
    for separator in separators:
        layout = TableLayout(text, separator)
        if len(separators) > 1 and _takes_decimals(layout, asked):
            continue
        if layout.refusal is not None:
            yield _Trial(
                TableFormat(separator, asked.decimal or POINT), layout, refusal=layout.refusal
            )
            continue
        for decimal in _decimals(layout, asked):
            table = layout.table(decimal, chosen=asked.decimal is not None)
            yield _Trial(table.way, layout, table, table.words())


def _takes_decimals(layout: TableLayout, asked: TableHints) -> bool:
    """True if commas divide all fields, although the user says that they divide decimals."""
    return layout.separator == asked.decimal == COMMA and not _has_marks(layout)


def _separators(text: SourceText, asked: TableHints) -> list[str]:
    """Return what may divide the fields: what is said, else what stands in most lines."""
    if asked.separator is not None:
        return [asked.separator]
    if text.separator is not None:
        named = [name for name, mark in SEPARATORS.items() if mark == text.separator]
        if not named and text.separator != " ":
            raise RefusedError(
                f"{text.path}:1: sep={text.separator}: expected one of "
                f"{' '.join(mark for mark in SEPARATORS.values() if mark.strip())}, or a tab"
            )
        return named or [BLANK]
    lines = [line for _, line in text.data]

    def divides(mark: str) -> bool:
        return 2 * sum(mark in line for line in lines) > len(lines)

    strong = [name for name in _STRONG if divides(SEPARATORS[name])]
    weak = [name for name, mark in (("comma", ","), (BLANK, " ")) if divides(mark)]
    return strong or [*weak, NONE]


def _decimals(layout: TableLayout, asked: TableHints) -> list[str]:
    """Return the marks of decimals that may be meant."""
    if asked.decimal is not None:
        return [asked.decimal]
    return [*DECIMALS] if _has_marks(layout) else [POINT]


def _has_marks(layout: TableLayout) -> bool:
    """True if a field has a mark of decimals or thousands."""
    return any("," in text or "." in text for _, fields in layout.rows for text in fields)


def _plausible(trials: list[_Trial]) -> list[_Trial]:
    """Return the ways that no other one is clearly better than."""
    tables = [trial for trial in trials if trial.table is not None]
    # A comma in a header divides names, where it divides as many fields. A blank may be in a name.
    if any(trial.layout.splits_header and trial.way.separator == "comma" for trial in trials):
        tables = [trial for trial in tables if trial.way.separator != NONE]
    if not all(trial.words for trial in tables):
        tables = [trial for trial in tables if not trial.words]

    def beaten(trial: _Trial) -> bool:
        same = (other for other in tables if other.way.separator == trial.way.separator)
        return any(other.words < trial.words for other in same)

    left = [trial for trial in tables if not beaten(trial)]
    return [*left, *_torn(trials)] if left else left


def _torn(trials: list[_Trial]) -> list[_Trial]:
    """Return ways in which a field is missing somewhere, where no header tells that they are wrong.

    2 between 1,5 and 2,5 may be a number, or a row that lacks its second one.
    """

    def fits(layout: TableLayout) -> bool:
        named = layout.names is None or layout.splits_header
        return layout.ragged and layout.width > 1 and named and _all_numbers(layout)

    return [trial for trial in trials if fits(trial.layout)]


def _all_numbers(layout: TableLayout) -> bool:
    texts = [text for _, fields in layout.rows for text in fields if text]
    return all(any(style.is_number(text) for style in STYLES.values()) for text in texts)


def _try(trial: _Trial, asked: TableHints) -> None:
    """Choose the column to import, and read it and those that are compared with the rows."""
    if trial.table is None:
        trial.meaning = ("torn", trial.way.separator)
        return
    try:
        columns = of_table(trial.table)
        column = choose(trial.table, columns, asked.column)
        used = {column.number} | {item.number for item in columns if item.quantity in (TIME, INDEX)}
        values = {number: tuple(trial.table.values(number)) for number in sorted(used)}
    except ChoiceError as error:
        trial.refusal = error
        if _has_numbers(trial.table, trial.words):
            trial.meaning = ("not chosen", trial.way.separator)
        return
    except UserError as error:
        trial.refusal = error
        return
    trial.reading = TableReading(trial.table, columns, column)
    trial.meaning = (column.number, *values.items())


def _has_numbers(table: TextTable, words: frozenset[tuple[int, int]]) -> bool:
    """True if a column has numbers alone."""
    return len({column for _, column in words}) < table.width


def _why(trials: list[_Trial]) -> UserError:
    """Return the refusal of a file that can be read in no way: that of the likeliest one."""
    refused = [trial for trial in trials if trial.refusal]
    first = refused[0].way.separator
    likely = [trial for trial in refused if trial.meaning is not None]
    likely = likely or [trial for trial in refused if trial.way.separator == first]
    refusal = min(likely, key=lambda trial: len(trial.words)).refusal
    assert refusal is not None
    return refusal


def _ambiguous(text: SourceText, groups: list[list[_Trial]]) -> RefusedError:
    """Return the refusal of a file that can be read in several ways."""
    line, seen = _difference(groups)
    raw = dict(text.lines)[line]
    ways = [f"{read} ({options})" for read, options in zip(seen, _options(groups), strict=True)][
        :_MOST_READINGS
    ]
    return RefusedError(f"{text.path}:{line}: {shown(raw)} can be read as {', or as '.join(ways)}")


def _difference(groups: list[list[_Trial]]) -> tuple[int, list[str]]:
    """Return the first line that the ways read differently, and what they read there."""
    rows = [dict(group[0].layout.rows) for group in groups]
    common = [line for line in rows[0] if all(line in row for row in rows)]
    for line in common:
        seen = [_seen(group[0], row[line]) for group, row in zip(groups, rows, strict=True)]
        if len(set(seen)) == len(seen):
            return line, seen
    line = common[0]
    return line, [_seen(group[0], row[line]) for group, row in zip(groups, rows, strict=True)]


def _seen(trial: _Trial, fields: list[str]) -> str:
    """Return what a way reads in a row, shortly."""
    style = STYLES[trial.way.decimal]
    numbers = [style.number(text) for text in fields]
    words = [
        text if number is None else _short(number)
        for text, number in zip(fields, numbers, strict=True)
    ]
    return words[0] if len(words) == 1 else f"{len(words)} columns {' | '.join(words)}"


def _short(number: Fraction) -> str:
    return f"{float(number):.10g}"


def _options(groups: list[list[_Trial]]) -> list[str]:
    """Return for each group of ways the options that leave no other one."""
    return [_option(group, groups) for group in groups]


def _option(group: list[_Trial], groups: list[list[_Trial]]) -> str:
    way = group[0].way
    decimal, separator = f"--decimal {way.decimal}", f"--separator {way.separator}"
    separators = [{trial.way.separator for trial in one} for one in groups]
    decimals = [{trial.way.decimal for trial in one} for one in groups]
    choices = [(separator, way.separator, separators), (decimal, way.decimal, decimals)]
    if way.separator == NONE:
        choices.reverse()
    for text, value, among in choices:
        if sum(value in one for one in among) == 1:
            return text
    return f"{decimal} {separator}"
