# SPDX-License-Identifier: MIT
"""The words of a motion program, a line of text at a time, so that no length needs memory."""

import re
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from typing import NamedTuple

from pixstep.errors import RefusedError
from pixstep.programs.expressions import (
    Expression,
    ExpressionReader,
    SyntaxMistakeError,
    Variables,
    constant,
    value_of,
)

AXIS_WORDS = "XYZABCUVW"
SET = "="  # the name of an item that gives a variable its value

_MODES = {
    "LINEAR": "LINEAR", "LIN": "LINEAR", "RAPID": "RAPID", "RPD": "RAPID",
    "CIRCLE1": "CIRCLE1", "CIR1": "CIRCLE1", "CIRCLE2": "CIRCLE2", "CIR2": "CIRCLE2",
}  # fmt: skip
_WITH_AXES = ("ABS", "INC", "FRAX")
_WITH_VALUE = {
    "DWELL": "DWELL", "DWE": "DWELL", "DELAY": "DELAY", "DLY": "DELAY",
    "TA": "TA", "TS": "TS", "TM": "TM", "F": "F",
    **{word: word for word in (*AXIS_WORDS, "I", "J", "R")},
}  # fmt: skip
_FRAME = ("OPEN", "CLOSE", "CLEAR")
KNOWN = (
    "LINEAR, RAPID, CIRCLE1, CIRCLE2, ABS, INC, FRAX, TA, TS, TM, F, DWELL, DELAY, "
    f"{' '.join(AXIS_WORDS)}, I J R, variables P1=... and Q1=..., labels N1, OPEN PROG 1, CLEAR, "
    "CLOSE"
)

_ALL = sorted([*_MODES, *_WITH_AXES, *_WITH_VALUE, *_FRAME, "PROG"], key=len, reverse=True)
_WORD = re.compile("|".join(_ALL), re.IGNORECASE)
_NUMBER = re.compile(r"[ \t]*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?![0-9.])")
_BLANKS = re.compile(r"[ \t]*")
_AXES = re.compile(r"[ \t]*\(([ \t]*[XYZABCUVW](?:[ \t]*,[ \t]*[XYZABCUVW])*[ \t]*)\)", re.I)
_OPEN = re.compile(r"[ \t]*PROG[ \t]*[0-9]+", re.IGNORECASE)
_LABEL = re.compile(r"[ \t]*N[0-9]+(?:[ \t]*:)?(?![0-9.])", re.IGNORECASE)
_LIKE_A_LABEL = re.compile(r"N[0-9]*", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"(?<=[0-9]),[0-9]")
_VARIABLE = re.compile(r"[PQ](?=[ \t]*[0-9(])", re.IGNORECASE)
_FOREIGN = re.compile(r"([IM][0-9]+)[ \t]*=", re.IGNORECASE)
_COMMENT = re.compile(r";.*|//.*|/\*.*?(?:\*/|$)")
_TEXT = re.compile(r"[^\W\d_]{2}")  # what makes a bracket a comment
_NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")
_LONGEST = 4096  # characters of a line
_SHOWN = 24


class ProgramWord(NamedTuple):
    """One thing that a line says: X12.5, TA10, ABS, P1=5; `column` is from 1.

    `expression` is None where the value is a number. `variable` is the letter and the number of
    the variable that a SET is for.
    """

    name: str
    value: float
    column: int
    text: str
    axes: tuple[str, ...] = ()
    expression: Expression | None = None
    variable: tuple[str, Expression] | None = None

    def valued(self, variables: Variables) -> "ProgramWord":
        """Return it with the value that its expression has now. Raises ValueError."""
        if self.expression is None:
            return self
        return self._replace(value=value_of(self.expression, variables), expression=None)


class ProgramRow(NamedTuple):
    """What a line of a program says, and its number from 1."""

    number: int
    items: tuple[ProgramWord, ...]


class ProgramError(RefusedError):
    """A mistake in a program; its text begins with file, line and column."""


def read(name: str, lines: Iterable[str]) -> Iterator[ProgramRow]:
    """Yield the lines of a program that say anything.

    Raises ProgramError naming file, line and column of the first mistake.
    """
    comments, frame = _Comments(), _Frame()
    for number, line in enumerate(lines, 1):
        try:
            text = comments.without(number, line)
            items = frame.inside(text) if text else ()
            if items:
                yield ProgramRow(number, items)
        except _MistakeError as mistake:
            raise ProgramError(f"{name}:{number}:{mistake.column}: {mistake}") from None
    if comments.begun:
        line_number, column = comments.begun
        raise ProgramError(f"{name}:{line_number}:{column}: /* without its */")


class _MistakeError(Exception):
    """What is wrong with a line, and from which column on."""

    def __init__(self, column: int, text: str) -> None:
        super().__init__(text)
        self.column = column


class _Comments:
    """Takes comments out of lines, blanks in their place; `begun` is where an open one begins."""

    def __init__(self) -> None:
        self.begun: tuple[int, int] | None = None

    def without(self, number: int, line: str) -> str:
        """Return a line without its comments and without what editors put around a text."""
        text = line.rstrip("\r\n\x1a")
        if number == 1:
            text = _decoded(text)
        if self.begun:
            before, end, text = text.partition("*/")
            if not end:
                return ""
            self.begun = None
            text = " " * len(before + end) + text

        def blank(found: re.Match[str]) -> str:
            if found[0].startswith("/*") and not found[0][2:].endswith("*/"):
                self.begun = number, found.start() + 1
            return " " * len(found[0])

        text = _COMMENT.sub(blank, text).rstrip()
        if len(text) > _LONGEST:
            raise _MistakeError(_LONGEST + 1, "the line is too long")
        return text


def _decoded(text: str) -> str:
    """Return the first line without a byte order mark; that of UTF-16 is a mistake."""
    if text.startswith("\ufffd\ufffd"):
        raise _MistakeError(1, "this is not UTF-8: save the program as UTF-8 (UTF-16 is not read)")
    return text.removeprefix("\ufeff")


class _Frame:
    """OPEN PROG, CLEAR and CLOSE around a program: one program, and nothing behind it."""

    def __init__(self) -> None:
        self._open = self._begun = self._closed = False

    def inside(self, text: str) -> tuple[ProgramWord, ...]:
        """Return what a line says in the program."""
        if self._closed:
            raise _MistakeError(1, f"{_cut(text)!r}: the program ends at CLOSE, a file has one")
        own = []
        for item in _items(text):
            if item.name not in _FRAME:
                self._begun = True
                own.append(item)
            elif item.name == "CLOSE":
                self._closed = self._open or self._begun  # one before OPEN closes what was open
            elif self._begun or (item.name == "OPEN" and self._open):
                raise _MistakeError(item.column, f"{item.name}: stands once, before all statements")
            else:
                self._open = self._open or item.name == "OPEN"
        return tuple(own)


@lru_cache(maxsize=4096)
def _items(text: str) -> tuple[ProgramWord, ...]:
    found, label = [], _LABEL.match(text)
    place = _blanks(text, label.end() if label else 0)
    while place < len(text):
        item, place = _item(text, place)
        if item:
            found.append(item)
        place = _blanks(text, place)
    return tuple(found)


def _blanks(text: str, place: int) -> int:
    blanks = _BLANKS.match(text, place)
    return blanks.end() if blanks else place


def _item(text: str, place: int) -> tuple[ProgramWord | None, int]:
    """Return what stands at a place, None for a comment, and the place behind it."""
    if text[place] == "(":
        return None, _bracket_end(text, place)
    if foreign := _FOREIGN.match(text, place):
        raise _MistakeError(place + 1, f"{foreign[1]}: of variables a program has P and Q")
    if _VARIABLE.match(text, place):
        return _assignment(text, place)
    word = _WORD.match(text, place)
    if word is None:
        raise _unknown(text, place)
    name = word[0].upper()
    if name in _WITH_VALUE:
        return _with_value(text, word)
    if name in _WITH_AXES:
        return _with_axes(text, word)
    if name == "OPEN":
        program = _OPEN.match(text, word.end())
        if program is None:
            raise _MistakeError(place + 1, "OPEN: expected OPEN PROG and a number")
        return ProgramWord(name, 0, place + 1, name), program.end()
    if name == "PROG":
        raise _unknown(text, place)
    return ProgramWord(_MODES.get(name, name), 0, place + 1, word[0]), word.end()


def _with_value(text: str, word: re.Match[str]) -> tuple[ProgramWord, int]:
    """Return a word with its number or its expression in brackets."""
    name, column = _WITH_VALUE[word[0].upper()], word.start() + 1
    if number := _NUMBER.match(text, word.end()):
        shown = f"{word[0]}{number[1]}"
        try:
            return ProgramWord(name, constant(number[1]), column, shown), number.end()
        except ValueError as error:
            raise _MistakeError(column, f"{_cut(shown)}: {error}") from None
    place = _blanks(text, word.end())
    if text[place : place + 1] != "(":
        raise _no_number(text, word, place)
    reader = ExpressionReader(text, place + 1)
    expression = _parsed(reader, reader.bracketed)
    shown = _cut(f"{word[0]}{text[place : reader.place]}")
    return ProgramWord(name, 0, column, shown, (), expression), reader.place


def _with_axes(text: str, word: re.Match[str]) -> tuple[ProgramWord, int]:
    """Return ABS, INC or FRAX with the axes in brackets, if there are any."""
    name, column = word[0].upper(), word.start() + 1
    if axes := _AXES.match(text, word.end()):
        letters = tuple(letter.strip().upper() for letter in axes[1].split(","))
        return ProgramWord(name, 0, column, word[0], letters), axes.end()
    place = _blanks(text, word.end())
    if text[place : place + 1] == "(" and not _TEXT.search(text[place:]):
        raise _MistakeError(place + 1, f"{_cut(text[place:])!r}: expected axes, as (X,Y)")
    return ProgramWord(name, 0, column, word[0]), word.end()


def _assignment(text: str, place: int) -> tuple[ProgramWord, int]:
    letter = text[place].upper()
    reader = ExpressionReader(text, _blanks(text, place + 1))
    index = _parsed(reader, lambda: reader.variable(letter))
    shown = text[place : reader.place]
    reader.place = _blanks(text, reader.place)
    if text[reader.place : reader.place + 1] != "=":
        raise _MistakeError(
            place + 1,
            f"{_cut(shown)}: a variable gets a value, {letter}1=5, or is one, X({letter}1)",
        )
    reader.place += 1
    expression = _parsed(reader, reader.sum)
    shown = _cut(text[place : reader.place])
    return ProgramWord(SET, 0, place + 1, shown, (), expression, (letter, index)), reader.place


def _parsed(reader: ExpressionReader, part: Callable[[], Expression]) -> Expression:
    """Return an expression; what is none is a mistake of the line."""
    begin = reader.place
    try:
        return part()
    except SyntaxMistakeError as error:
        rest = reader.text[error.place :]
        shown = repr(_cut(rest)) if rest.strip() else "the line ends"
        raise _MistakeError(error.place + 1, f"{shown}: {error}") from None
    except ValueError as error:
        raise _MistakeError(begin + 1, f"{_cut(reader.text[begin:])}: {error}") from None


def _bracket_end(text: str, place: int) -> int:
    """Return the place behind a comment in brackets; an expression that belongs to no word is none.

    Programs that CAM software writes have such comments.
    """
    depth = 0
    for end in range(place, len(text)):
        depth += (text[end] == "(") - (text[end] == ")")
        if depth == 0 and _TEXT.search(text[place:end]):
            try:
                ExpressionReader(text, place + 1).bracketed()
            except (SyntaxMistakeError, ValueError):
                return end + 1
        if depth == 0:
            break
    raise _MistakeError(place + 1, f"{_cut(text[place:])!r}: a bracket that belongs to no word")


def _no_number(text: str, word: re.Match[str], place: int) -> _MistakeError:
    """Return what is wrong where a word has no number: perhaps it is no word at all."""
    if place == len(text):
        return _MistakeError(place + 1, "the line ends where a number is expected")
    if text[place] not in "0123456789.+-":
        name = _NAME.match(text, word.start())
        if name and len(name[0]) > len(word[0]):
            return _unknown(text, word.start())
        if _NAME.match(text, place):
            return _unknown(text, place)
    return _MistakeError(place + 1, f"{_cut(text[place:])!r}: expected a number")


def _unknown(text: str, place: int) -> _MistakeError:
    if _DECIMAL_COMMA.match(text, place):
        return _MistakeError(
            place + 1, f"{_cut(text[place:])!r}: a decimal point is expected, as in 12.5"
        )
    begin = place
    while (
        _NAME.match(text, place) and begin and (text[begin - 1].isalnum() or text[begin - 1] == "_")
    ):
        begin -= 1
    name = _NAME.match(text, begin) or _NAME.match(text, place)
    if name and _LIKE_A_LABEL.fullmatch(name[0]):
        return _MistakeError(
            name.start() + 1,
            f"{_cut(name[0])}: a label is N and a whole number and begins a line",
        )
    if name is None:
        return _MistakeError(
            place + 1, f"{_cut(text[place:])!r}: expected a word of the language: {KNOWN}"
        )
    return _MistakeError(name.start() + 1, f"unknown word {_cut(name[0])!r}, known are: {KNOWN}")


def _cut(text: str) -> str:
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
