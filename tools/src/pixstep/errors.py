# SPDX-License-Identifier: MIT
"""The exceptions that reach a user as a plain line of text, and the exit statuses of commands."""

from typing import Any

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
