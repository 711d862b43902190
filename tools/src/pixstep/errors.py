# SPDX-License-Identifier: MIT
"""The exceptions that reach a user as a plain line of text, and the exit statuses of commands."""

from collections.abc import Mapping
from typing import Any, Self

FINE = 0
NEGATIVE = 1  # a verdict that is not fine: a failed run, warnings, a difference, a board in trouble
MISUSE = 2
REFUSED = 3  # by a check, before anything is done, or by a board


class PlainError(Exception):
    """Ends a command with its text as one line and with the exit status `status`."""

    status: int = NEGATIVE
    """Exit status of a command that it ends."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Let every kind pass from one process to another, whatever it is made of."""
        return _again, (type(self), self.args, self.__dict__)


def _again(kind: type[PlainError], args: tuple[Any, ...], values: dict[str, Any]) -> PlainError:
    """Return an error with its text and its values."""
    made = kind.__new__(kind, *args)
    made.args = args
    made.__dict__.update(values)
    return made


class AskedText(str):
    """A text that speaks of what was asked for: `AskedText("{text}: needs {pixel_hz}", text=text)`.

    A name in braces that is no value given here is that of an option, as Python spells it: the
    text has it so, `told` has a front end's word. A value may be such a text, or an error with one.
    """

    __slots__ = ("template", "values")
    template: str
    values: Mapping[str, Any]

    def __new__(cls, template: str, **values: Any) -> Self:
        """Make the text."""
        made = super().__new__(cls, _filled(template, values, {}))
        made.template, made.values = template, values
        return made

    def __getnewargs_ex__(self) -> tuple[tuple[str], dict[str, Any]]:
        """Return what it is made of, for another process."""
        return (self.template,), dict(self.values)

    def told(self, words: Mapping[str, str]) -> str:
        """Return the text with a front end's words for names; a name without one is kept."""
        return _filled(self.template, self.values, words)


def told(text: object, words: Mapping[str, str]) -> str:
    """Return a text, or that of an error, with a front end's words for what was asked for."""
    if isinstance(text, PlainError) and len(text.args) == 1:
        (text,) = text.args
    return text.told(words) if isinstance(text, AskedText) else str(text)


def _filled(template: str, values: Mapping[str, Any], words: Mapping[str, str]) -> str:
    known = {
        name: told(value, words) if isinstance(value, (AskedText, PlainError)) else value
        for name, value in values.items()
    }
    return template.format_map(_Words(words, known))


class _Words(dict[str, Any]):
    def __init__(self, words: Mapping[str, str], known: Mapping[str, Any]) -> None:
        super().__init__(known)
        self._words = words

    def __missing__(self, name: str) -> str:
        try:
            return self._words[name]
        except KeyError:
            return name


class UserError(PlainError):
    """A mistake or a lack that the user can mend."""

    status = MISUSE


class RefusedError(UserError):
    """A check refuses what a file holds."""

    status = REFUSED


MOST_CHARACTERS = 400  # of a message: what is longer repeats a value, and hides the reason


def one_line(text: str, most: int = MOST_CHARACTERS) -> str:
    """Return a text as one line, its control characters written out, its middle left out if long.

    What a file or a board says could otherwise move a terminal's cursor, or fill it.
    """
    joined = " ".join(row.strip() for row in text.splitlines()).strip()
    shown = "".join(
        one if one.isprintable() or _is_byte(one) else repr(one)[1:-1] for one in joined
    )
    half = most // 2
    return shown if len(shown) <= most else f"{shown[:half]} ... {shown[-half:]}"


def _is_byte(one: str) -> bool:
    """True for a byte of a file's name that is no text: a stream writes it back as it was."""
    return "\udc80" <= one <= "\udcff"
