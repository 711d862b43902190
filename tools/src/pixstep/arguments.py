# SPDX-License-Identifier: MIT
"""Arguments of a program's calls: what is not of the right kind or range is a UserError.

A number may be Python's or numpy's, a Fraction or a Decimal; of one in floating point the digits
count that it shows. A truth value is no number.
"""

import math
import os
import reprlib
from collections.abc import Collection, Iterable, Mapping, Sized
from decimal import Decimal
from fractions import Fraction
from itertools import islice
from numbers import Rational, Real
from pathlib import Path
from typing import Any, TypeVar

from pixstep.errors import UserError

FAR = 1_000_000_000  # what no count, speed or time of a motion needs
_MOST_DIGITS = 400  # of a Decimal, before and behind its point

_Kind = TypeVar("_Kind")


def number(value: Any) -> Fraction | None:
    """Return a number, exactly; None for anything else, and for one that is not finite."""
    plain = _plain(value)
    if isinstance(plain, bool):
        return None
    if isinstance(plain, Rational):
        return Fraction(plain)
    if isinstance(plain, Decimal):
        small = plain.is_finite() and abs(plain.adjusted()) <= _MOST_DIGITS
        return Fraction(plain) if small else None
    if isinstance(plain, Real) and math.isfinite(plain):
        return Fraction(str(plain))
    return None


def exact(name: str, value: Any, low: float = -FAR, high: float = FAR) -> Fraction:
    """Return a number in a range, exactly."""
    found = number(value)
    if found is None or not low <= found <= high:
        raise _wrong(name, value, f"a number{_range(low, high)}")
    return found


def finite(name: str, value: Any, low: float = -FAR, high: float = FAR) -> float:
    """Return a number in a range."""
    if isinstance(value, float) and low <= value <= high:
        return float(value)
    return float(exact(name, value, low, high))


def whole(name: str, value: Any, low: int = 0, high: float = FAR) -> int:
    """Return a whole number in a range."""
    found = _whole(value, low, high)
    if found is None:
        raise _wrong(name, value, f"a whole number{_range(low, high)}")
    return found


def wholes(name: str, values: Any, low: int, high: int, most: int) -> tuple[int, ...]:
    """Return whole numbers, one a pixel: of a list, an array or an iterator of at most `most`."""
    found = []
    for place, value in enumerate(_items(name, values, most), 1):
        read = _whole(value, low, high)
        if read is None:
            raise _wrong(f"{name}: pixel {place}:", value, f"a whole number{_range(low, high)}")
        found.append(read)
    return tuple(found)


def finites(name: str, values: Any, low: float, high: float, most: int) -> tuple[float, ...]:
    """Return the same of numbers that need not be whole."""
    return tuple(
        finite(f"{name}: pixel {place}:", value, low, high)
        for place, value in enumerate(_items(name, values, most), 1)
    )


def one_of(name: str, value: Any, words: Collection[str]) -> str:
    """Return a word of several."""
    if not isinstance(value, str) or value not in words:
        raise _wrong(name, value, f"one of {', '.join(words)}")
    return str(value)


def text(name: str, value: Any) -> str:
    """Return a text."""
    if not isinstance(value, str):
        raise _wrong(name, value, "a text")
    return str(value)


def flag(name: str, value: Any) -> bool:
    """Return a truth value."""
    plain = _plain(value)
    if not isinstance(plain, bool):
        raise _wrong(name, value, "True or False")
    return plain


def path(name: str, value: Any) -> Path:
    """Return the path of a file or folder; whether there is one is not asked."""
    if not isinstance(value, str | os.PathLike):
        raise _wrong(name, value, "the path of a file")
    found = os.fspath(value)
    if not isinstance(found, str) or not found or "\0" in found:
        raise _wrong(name, value, "the path of a file")
    try:
        os.fsencode(found)
    except UnicodeError:
        raise _wrong(name, value, "the path of a file") from None
    return Path(found)


def instance(name: str, value: Any, kind: type[_Kind], what: str) -> _Kind:
    """Return an object of a class, `what` in words."""
    if not isinstance(value, kind):
        raise _wrong(name, value, what)
    return value


def function(name: str, value: Any) -> None:
    """Refuse what cannot be called."""
    if not callable(value):
        raise _wrong(name, value, "a function")


def shown(value: Any) -> str:
    """Return a value as a message has it: short, on one line."""
    plain = _plain(value)
    try:
        text = str(plain) if isinstance(plain, Real) else reprlib.repr(plain)
    except ValueError:  # Python writes no whole number of thousands of digits
        return "of too many digits"
    return " ".join(text.split())


def _wrong(name: str, value: Any, expected: str) -> UserError:
    return UserError(f"{name} {shown(value)}: expected {expected}")


def _range(low: float, high: float) -> str:
    """Return a range in words: an end that is far away is none."""
    if high not in (FAR, math.inf):
        return f", {low} to {high}"
    return "" if low == -FAR else f", {low} or more"


def _plain(value: Any) -> Any:
    """Return a number of numpy as Python's own, where Python has such a one."""
    if getattr(value, "ndim", None) == 0 and hasattr(value, "item"):
        return value.item() if value.dtype.kind in "biu" or value.dtype == float else value[()]
    return value


def _whole(value: Any, low: float, high: float) -> int | None:
    """Return a whole number in a range; None for anything else."""
    quick = type(value) is int or isinstance(value, float)
    found = value if quick else number(value)
    if found is None or not low <= found <= high or found % 1:
        return None
    return int(found)


def _items(name: str, values: Any, most: int) -> list[Any]:
    """Return what a list, an array or another row of numbers holds."""
    if isinstance(values, str | bytes | Mapping | set | frozenset | os.PathLike):
        raise _wrong(name, values, "a list of numbers or an array")
    if not isinstance(values, Iterable) or getattr(values, "ndim", 1) != 1:
        raise _wrong(name, values, "a list of numbers or an array of one dimension")
    if getattr(getattr(values, "dtype", None), "kind", "O") in "iuf" and hasattr(values, "tolist"):
        return list(values.tolist())  # of numpy: Python's own numbers take less time to read
    if isinstance(values, Sized):
        return list(values)
    found = list(islice(values, most + 1))
    if len(found) > most:
        raise UserError(f"{name}: more than {most} numbers, or no end of them")
    return found
