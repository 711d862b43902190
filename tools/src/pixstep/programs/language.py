# SPDX-License-Identifier: MIT
"""The words of a motion program, a line of text at a time, so that no length needs memory."""

import re
from collections.abc import Iterable, Iterator
from functools import cache, lru_cache
from typing import NamedTuple

from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedInput, UnexpectedToken

from pixstep.errors import RefusedError

AXIS_WORDS = "XYZABCUVW"

_GRAMMAR = r"""
start: item*
?item: "LINEAR"i -> linear
     | "CIRCLE1"i -> clockwise
     | "CIRCLE2"i -> counterclockwise
     | ABS axes? -> absolute
     | INC axes? -> incremental
     | FRAX axes? -> feed_axes
     | SETTING value -> setting
     | WORD value -> word
axes: "(" LETTER ("," LETTER)* ")"
value: NUMBER | "(" NUMBER ")"

ABS.3: "ABS"i
INC.3: "INC"i
FRAX.3: "FRAX"i
SETTING.2: /TA|TS|TM|DWELL|DELAY|F/i
WORD: /[XYZABCUVWIJR]/i
LETTER: /[XYZABCUVW]/i
NUMBER: /[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)(?![0-9.])/
%ignore /[ \t]+/
"""
_KEYWORDS = ("LINEAR", "CIRCLE1", "CIRCLE2", "ABS", "INC", "FRAX", "TA", "TS", "TM", "DWELL",
             "DELAY", "F", *AXIS_WORDS, "I", "J", "R")  # fmt: skip
_COMMENT = re.compile(r"[;].*|//.*")
_NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_LONGEST = 4096  # characters of a line
_SHOWN = 24


class Item(NamedTuple):
    """One thing that a line says: X12.5, TA10, ABS; `column` is from 1."""

    name: str
    value: float
    column: int
    text: str
    axes: tuple[str, ...] = ()


class Row(NamedTuple):
    """What a line of a program says, and its number from 1."""

    number: int
    items: tuple[Item, ...]


class ProgramError(RefusedError):
    """A mistake in a program; its text begins with file, line and column."""


class _Items(Transformer[Token, tuple[Item, ...]]):
    """Makes items while the parser reads, without a tree."""

    def start(self, found: list[Item]) -> tuple[Item, ...]:
        return tuple(found)

    def linear(self, _: list[Token]) -> Item:
        return Item("LINEAR", 0, 1, "LINEAR")

    def clockwise(self, _: list[Token]) -> Item:
        return Item("CIRCLE1", 0, 1, "CIRCLE1")

    def counterclockwise(self, _: list[Token]) -> Item:
        return Item("CIRCLE2", 0, 1, "CIRCLE2")

    def axes(self, found: list[Token]) -> tuple[str, ...]:
        return tuple(str(token).upper() for token in found)

    def value(self, found: list[Token]) -> Token:
        return found[0]

    def _named(self, found: tuple[Token] | tuple[Token, tuple[str, ...]]) -> Item:
        word, axes = found if len(found) == 2 else (*found, ())
        return Item(word.upper(), 0, word.column or 1, str(word), axes)

    absolute = incremental = feed_axes = _named

    def setting(self, found: list[Token]) -> Item:
        word, number = found
        return Item(word.upper(), float(number), word.column or 1, f"{word}{number}")

    word = setting


@cache
def _parser() -> Lark:
    return Lark(_GRAMMAR, parser="lalr", lexer="contextual", transformer=_Items())


@lru_cache(maxsize=4096)
def _items(text: str) -> tuple[Item, ...]:
    return _parser().parse(text)  # type: ignore[return-value]  # the transformer's start


def read(name: str, lines: Iterable[str]) -> Iterator[Row]:
    """Yield the lines of a program that say anything.

    Raises ProgramError naming file, line and column of the first mistake.
    """
    for number, line in enumerate(lines, 1):
        text = _COMMENT.sub("", line.rstrip("\r\n"))
        if len(text) > _LONGEST:
            raise ProgramError(f"{name}:{number}:{_LONGEST + 1}: the line is too long")
        if text.isspace() or not text:
            continue
        try:
            yield Row(number, _items(text))
        except UnexpectedInput as error:
            column, mistake = _mistake(text, _place(error, text))
            raise ProgramError(f"{name}:{number}:{column}: {mistake}") from None


def _place(error: UnexpectedInput, text: str) -> int:
    """Return the column, from 1, at which the parser stopped."""
    at_end = isinstance(error, UnexpectedToken) and error.token.type == "$END"
    return len(text.rstrip()) + 1 if at_end else error.column


def _mistake(text: str, column: int) -> tuple[int, str]:
    """Return the column of what the parser stumbled over, and in words what it is."""
    rest = text[column - 1 :]
    if not rest.strip():
        return column, "the line ends where a number is expected"
    for found in _NAME.finditer(text):
        if found.start() < column <= found.end() and not _known(found[0]):
            return found.start() + 1, f"unknown word {_cut(found[0])!r}"
    before = _NAME.findall(text[: column - 1])
    wants = "number" if before and before[-1].upper() in _KEYWORDS[6:] else "word of the language"
    return column, f"{_cut(rest)!r}: expected a {wants}"


def _known(word: str) -> bool:
    """True if a word begins as the language's do: TA10 or X5Y7 are one name to a pattern."""
    return word.upper().startswith(_KEYWORDS[:6]) or bool(
        re.fullmatch(r"(?:(?:TA|TS|TM|DWELL|DELAY|[FXYZABCUVWIJR])[0-9]*)+", word, re.IGNORECASE)
    )


def _cut(text: str) -> str:
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
